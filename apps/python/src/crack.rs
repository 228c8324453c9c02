//! `simulate`, `crack` and `corrupt`.

use pyo3::prelude::*;

use crate::arguments::{BoxesArg, Given, NameArg, SeedArg, SizeArg, Whole, seed_of};
use crate::errors::raised_in_memory;
use crate::images::image_of;
use crate::network::CrackNetwork;
use crate::ready::{ReadyCrack, network_of};
use crate::recipe::{Recipe, RecipeArg};

/// The crack network of the glass in front of a frame.
///
/// recipe: a `Recipe`, the name of a preset, or tables as a dict; default `windshield-spiderweb`.
/// seed: 0 to 2**64 - 1, determines everything random.
/// size: width and height of the frame, px.
///
/// Raises `ValueError` for wrong parameters, `SimulationError` if the models have no result.
///
/// >>> import starbreak
/// >>> network = starbreak.simulate("windshield-star", seed=7)
/// >>> network.unit, network.damage_class
/// ('mm', 'star')
/// >>> len(network) == len(network.segments["arrival_us"])
/// True
#[pyfunction]
#[pyo3(
    signature = (recipe = None, seed = SeedArg::ZERO, size = SizeArg::DEFAULT),
    text_signature = "(recipe=None, seed=0, size=(1242, 375))"
)]
pub(crate) fn simulate(
    py: Python<'_>,
    recipe: Option<RecipeArg>,
    seed: SeedArg,
    size: SizeArg,
) -> PyResult<CrackNetwork> {
    let settings = RecipeArg::or_default(recipe)?.settings();
    let simulated = py.detach(|| starbreak::simulate(&settings, size.0, seed.0));
    Ok(CrackNetwork::of(
        simulated.map_err(|error| raised_in_memory(&error))?.network,
    ))
}

/// The seed of an item of a dataset, derived from the seed of the run, the name of the item and the
/// sample number, as the command does for each image.
///
/// >>> import starbreak
/// >>> starbreak.item_seed(7, "photo.png") == starbreak.item_seed(7, "other.png")
/// False
#[pyfunction]
#[pyo3(
    signature = (seed, name, sample_index = Whole::of(0)),
    text_signature = "(seed, name, sample_index=0)"
)]
#[expect(clippy::needless_pass_by_value, reason = "arguments come as values")]
pub(crate) fn item_seed(seed: SeedArg, name: NameArg, sample_index: Whole) -> PyResult<u64> {
    Ok(seed_of(seed, Some(&name), &sample_index)?.0)
}

/// The image behind broken glass, as a new array of the same shape; `image` is not changed.
///
/// image: uint8, H x W x 3 (sRGB), H x W x 4 (its alpha stays, or is moved by a distortion) or
/// H x W (gray), any strides; 1 to 32768 px per side; or an image of Pillow in the mode RGB, RGBA or L.
/// recipe: a `Recipe`, the name of a preset, or tables as a dict; default `windshield-spiderweb`.
/// severity: 1 (mild) to 5 (severe), of a preset.
/// seed: 0 to 2**64 - 1, determines everything random.
/// name, sample_index: with a name, the seed is `item_seed(seed, name, sample_index)`. With the
/// name that the command uses, the pixels are the command's: `starbreak crack` uses the file's name
/// (`photo.png`), `starbreak generate` its path in the dataset.
/// network: cracks to show instead of simulated ones.
/// boxes: boxes [x0, y0, x1, y1] in px whose damage is measured; the result is then a `Cracked`.
/// full: return a `Cracked`, with masks, network and facts, instead of the array.
///
/// Runs in the calling thread only and releases the interpreter's lock. Raises `TypeError` if
/// `image` is not an array, `ValueError` for another dtype or shape and for wrong parameters,
/// `SimulationError` if the models have no result.
///
/// >>> import numpy as np, starbreak
/// >>> image = np.full((375, 1242, 3), 128, np.uint8)
/// >>> cracked = starbreak.crack(image, "windshield-star", seed=7)
/// >>> cracked.shape, cracked.dtype
/// ((375, 1242, 3), dtype('uint8'))
/// >>> full = starbreak.crack(image, "windshield-star", seed=7, boxes=[[600, 100, 700, 200]])
/// >>> bool((full.image == cracked).all()), full.region.shape
/// (True, (375, 1242))
/// >>> sorted(full.damage[0])
/// ['blur_radius_px', 'contrast_lost', 'displacement_px', 'region_share']
#[pyfunction]
#[pyo3(
    signature = (image, recipe = None, seed = SeedArg::ZERO, *, severity = None, name = None, sample_index = Whole::of(0), network = None, boxes = None, full = Given::of(false)),
    text_signature = "(image, recipe=None, seed=0, *, severity=None, name=None, sample_index=0, network=None, boxes=None, full=False)"
)]
#[expect(
    clippy::too_many_arguments,
    reason = "they have names and defaults in Python"
)]
pub(crate) fn crack<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    recipe: Option<RecipeArg>,
    seed: SeedArg,
    severity: Option<Whole>,
    name: Option<NameArg>,
    sample_index: Whole,
    network: Option<Given<Py<CrackNetwork>>>,
    boxes: Option<BoxesArg>,
    full: Given<bool>,
) -> PyResult<Bound<'py, PyAny>> {
    let (network, full) = (Given::if_given(network, "network")?, full.named("full")?);
    let recipe = RecipeArg::at_severity(recipe, severity.as_ref())?;
    let pixels = image_of(image)?;
    let seed = seed_of(seed, name.as_ref(), &sample_index)?;
    let size = (pixels.width(), pixels.height());
    ReadyCrack::fresh(py, recipe, seed, size, network_of(network))?
        .shown_in(py, pixels, None, seed, boxes, full)
}

/// The image behind broken glass, with the signature of `imagecorruptions.corrupt` plus a seed.
///
/// image: uint8, H x W x 3 or H x W.
/// corruption_name: the name of a preset, see `presets`.
/// severity: 1 (mild) to 5 (severe); each preset defines which physical parameters this sets.
/// seed: 0 to 2**64 - 1, determines everything random.
///
/// Raises the same errors as `crack`.
///
/// >>> import numpy as np, starbreak
/// >>> image = np.full((375, 1242, 3), 128, np.uint8)
/// >>> starbreak.corrupt(image, "windshield-star", severity=3, seed=7).shape
/// (375, 1242, 3)
#[pyfunction]
#[pyo3(
    signature = (image, corruption_name = Given::of(starbreak::DEFAULT_PRESET.to_owned()), severity = Whole::of(1), *, seed = SeedArg::ZERO),
    text_signature = "(image, corruption_name='windshield-spiderweb', severity=1, *, seed=0)"
)]
pub(crate) fn corrupt<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    corruption_name: Given<String>,
    severity: Whole,
    seed: SeedArg,
) -> PyResult<Bound<'py, PyAny>> {
    let corruption_name = corruption_name.named("corruption_name")?;
    let recipe = Recipe::named(&corruption_name, Some(&severity))?;
    let sample_index = Whole::of(0);
    crack(
        py,
        image,
        Some(RecipeArg::of(recipe)),
        seed,
        None,
        None,
        sample_index,
        None,
        None,
        Given::of(false),
    )
}
