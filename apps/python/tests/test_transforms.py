"""The transform without a framework, and the drawing of cracks that all transforms share."""

import doctest
import importlib
import multiprocessing
import pathlib
import pickle

import numpy as np
import pytest
import starbreak
from conftest import SMALL, picture
from starbreak.transforms import CrackedGlass


@pytest.mark.parametrize("module", ["starbreak._drawing", "starbreak.transforms"])
def test_examples_in_the_docstrings_run(module):
    result = doctest.testmod(importlib.import_module(module))
    assert (result.failed, result.attempted > 0) == (0, True)


def test_a_key_and_an_epoch_give_the_crack_of_their_item_seed(image, small):
    transform = CrackedGlass(small, seed=7)
    np.testing.assert_array_equal(transform(image, "a.png"), starbreak.crack(image, small, 7, name="a.png"))
    transform.set_epoch(3)
    third = starbreak.crack(image, small, 7, name="a.png", sample_index=3)
    np.testing.assert_array_equal(transform(image, "a.png"), third)
    assert (third != image).any()


def test_images_differ_by_key_by_pixels_and_by_seed(image, small):
    results = [
        CrackedGlass(small, seed=7)(image),
        CrackedGlass(small, seed=8)(image),
        CrackedGlass(small, seed=7)(image, "a.png"),
        CrackedGlass(small, seed=7)(image, 5),
    ]
    assert len({result.tobytes() for result in results}) == 4
    other = image.copy()
    other[16, 5] += 1
    drawing = CrackedGlass(small, seed=7)._drawing
    assert drawing.seed_of(image) == drawing.seed_of(np.asfortranarray(image))
    assert drawing.seed_of(image) != drawing.seed_of(other)


def test_the_region_comes_on_request(image, small):
    cracked, region = CrackedGlass(small, seed=7, region=True)(image, "a.png")
    full = starbreak.crack(image, small, 7, name="a.png", full=True)
    np.testing.assert_array_equal(cracked, full.image)
    np.testing.assert_array_equal(region, full.region)
    spared, nothing = CrackedGlass(small, seed=7, p=0.0, region=True)(image)
    assert spared is image
    assert nothing.shape == image.shape[:2] and not nothing.any()


def test_an_image_with_one_channel_keeps_its_shape(small):
    gray = np.ascontiguousarray(picture()[..., :1])
    cracked = CrackedGlass(small)(gray, "a")
    assert cracked.shape == gray.shape
    np.testing.assert_array_equal(cracked[..., 0], CrackedGlass(small)(gray[..., 0], "a"))


def test_share_and_severities_are_drawn_evenly():
    drawing = CrackedGlass("paper", severity=(2, 4), p=0.3)._drawing
    seeds = [drawing.seed_of(None, k) for k in range(4000)]
    share = np.mean([drawing.is_drawn(seed) for seed in seeds])
    assert abs(share - 0.3) < 4 * np.sqrt(0.3 * 0.7 / 4000)
    recipes = [drawing.recipe_of(seed) for seed in seeds]
    for severity in (2, 3, 4):
        share = recipes.count(starbreak.Recipe("paper", severity=severity)) / 4000
        assert abs(share - 1 / 3) < 4 * np.sqrt(2 / 9 / 4000), severity
    # Whether there is a crack says nothing of how severe it is.
    drawn = [recipe for recipe, seed in zip(recipes, seeds, strict=True) if drawing.is_drawn(seed)]
    assert abs(drawn.count(starbreak.Recipe("paper", severity=2)) / len(drawn) - 1 / 3) < 0.06


def test_a_bank_gives_what_the_bank_gives(command, tmp_path, image):
    command("patterns", "-n", 3, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    bank = starbreak.PatternBank(tmp_path)
    transform = CrackedGlass(bank=tmp_path, seed=7, region=True)
    for name in "abcd":
        full = bank.crack(image, 7, name=name, full=True)
        cracked, region = transform(image, name)
        np.testing.assert_array_equal(cracked, full.image)
        np.testing.assert_array_equal(region, full.region)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ValueError, {"p": 1.5}),
        (ValueError, {"p": float("nan")}),
        (ValueError, {"severity": 0}),
        (ValueError, {"severity": (1, 2, 3)}),
        (ValueError, {"severity": (3, 1)}),
        (TypeError, {"severity": (1.5, 2)}),
        (TypeError, {"severity": 2.5}),
        (TypeError, {"severity": True}),
        (TypeError, {"p": "a"}),
        (TypeError, {"p": None}),
        (ValueError, {"recipe": "no such preset"}),
        (ValueError, {"recipe": {"camera": {"fpx": 3}}}),
        (ValueError, {"recipe": {"camera": {"f_number": 4.0}}, "severity": 2}),
        (ValueError, {"recipe": "paper", "bank": "somewhere"}),
        (ValueError, {"severity": 1, "bank": "somewhere"}),
        (FileNotFoundError, {"bank": "no/such/bank"}),
        (TypeError, {"recipe": 5}),
        (TypeError, {"seed": "7"}),
        (ValueError, {"seed": -1}),
    ],
)
def test_wrong_parameters_are_refused_at_construction(error, words):
    with pytest.raises(error) as raised:
        CrackedGlass(**words)
    if error is TypeError:
        (name, value), = words.items()
        assert str(raised.value).startswith(f"{name} = {value!r}") and "; expected" in str(raised.value)


def test_an_epoch_is_a_whole_number(small):
    transform = CrackedGlass(small)
    for error, wrong in ((ValueError, -1), (ValueError, 2**64), (TypeError, 1.5), (TypeError, "1")):
        with pytest.raises(error, match=f"epoch = {wrong!r}; expected a whole number"):
            transform.set_epoch(wrong)


def test_it_says_what_it_draws(small):
    assert repr(CrackedGlass("paper", severity=(1, 3), p=0.5)) == (
        "CrackedGlass(recipe='paper', severity=(1, 3), seed=0, region=False, p=0.5)"
    )
    assert repr(CrackedGlass(small, seed=7)) == f"CrackedGlass(recipe={small!r}, seed=7, region=False, p=1.0)"


def test_what_is_no_array_is_refused_in_a_call(small):
    for wrong in (None, [[1, 2]], "photo.png"):
        for key in (None, "a"):
            with pytest.raises(TypeError, match=f"image is of type {type(wrong).__name__}; expected a numpy.ndarray"):
                CrackedGlass(small)(wrong, key)


def test_other_dtypes_and_shapes_are_refused_in_a_call(image, small):
    for wrong in (image.astype(np.float32), image[..., :2], image[0, 0], image[:0], np.empty((4, 4), object)):
        with pytest.raises(ValueError):
            CrackedGlass(small)(wrong, "a")


def cracked_by(transform, key):
    return transform(picture(seed=key), key).tobytes()


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("n_workers", [0, 1, 2, 4])
def test_any_number_of_workers_makes_the_same_set(method, n_workers):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system cannot {method}")
    transform = CrackedGlass(starbreak.Recipe("paper", set=SMALL), seed=7, p=0.7)
    transform.set_epoch(2)
    items = [(transform, key) for key in range(8)]
    expected = [cracked_by(*item) for item in items]
    assert len(set(expected)) == 8
    if n_workers == 0:
        made = [cracked_by(pickle.loads(pickle.dumps(transform)), key) for _, key in items]
    else:
        with multiprocessing.get_context(method).Pool(n_workers) as pool:
            made = pool.starmap(cracked_by, items, chunksize=1)
    assert made == expected


@pytest.mark.parametrize("key", [True, object(), np.zeros(3), b"a.png", ["a"]], ids=lambda key: type(key).__name__)
def test_a_key_is_a_path_or_a_number(image, small, key):
    with pytest.raises(TypeError, match="key is of type .*; expected what tells images apart"):
        CrackedGlass(small)(image, key)
    transform = CrackedGlass(small)
    np.testing.assert_array_equal(transform(image, pathlib.PurePath("a.png")), transform(image, "a.png"))
    np.testing.assert_array_equal(transform(image, np.int64(3)), transform(image, 3))


def test_a_spared_image_is_looked_at_as_well(image, small):
    transform = CrackedGlass(small, p=0.0)
    for unfit, named in ((image.astype(float), "dtype float64"), (image[:0], "no pixel"), (image[..., :2], "shape")):
        with pytest.raises(ValueError, match=named):
            transform(unfit, "a.png")


def test_no_name_is_no_preset():
    for severity in (None, 2):
        with pytest.raises(ValueError, match="preset"):
            CrackedGlass("", severity=severity)
