//! Photographs of broken glass from files, one or a folder of them.

use std::path::Path;
use std::sync::Arc;

use rand_chacha::rand_core::Rng;
use rayon::prelude::*;
use serde_json::{Value, json};
use starbreak::photo::{GlassPhoto, OverlayOptions, PlacedPhoto};
use starbreak_dataset::{
    ImageFile, ImageLimits, Source, SourceFormat, SourceImage, SourceSpec, decode_image,
    read_image, sha256_hex,
};
use starbreak_optics::photo::{Background, Photo, PhotoParams};
use starbreak_seed::{Seed, Stream};

use crate::Error;

/// Longest side of a photograph of a set, px; larger ones are shrunk, so that a set fits in
/// memory: at the least scale of 0.6 it still has a pixel for each of a frame of 2457 px.
const MOST_SIDE_PX: u32 = 4096;

/// Photographs of broken glass, of which each frame gets a random part of a random one.
#[derive(Debug, Clone, PartialEq)]
pub struct OverlaySet {
    photos: Vec<Arc<GlassPhoto>>,
    options: OverlayOptions,
}

impl OverlaySet {
    /// One photograph.
    #[must_use]
    pub fn of(glass: GlassPhoto, options: &OverlayOptions) -> Self {
        Self {
            photos: vec![Arc::new(glass)],
            options: *options,
        }
    }

    /// The PNG and JPEG files below a folder, in the order of their names.
    ///
    /// # Errors
    /// [`Error::Dataset`] if the folder or a file cannot be read, [`Error::OfImage`] naming a file
    /// that shows no glass, [`Error::NoPhotos`] for a folder without any.
    pub fn read(folder: &Path, options: &OverlayOptions) -> Result<Self, Error> {
        let photos = photo_files(folder)?
            .par_iter()
            .map(|file| read_as(&file.path, &file.name, &options.params))
            .map(|glass| Ok(shrunk(glass?)))
            .collect::<Result<_, Error>>()?;
        Ok(Self {
            photos,
            options: *options,
        })
    }

    /// Some photographs that have been read, of which the large ones are shrunk.
    pub(crate) fn of_all(photos: Vec<GlassPhoto>, options: &OverlayOptions) -> Self {
        Self {
            photos: photos.into_par_iter().map(shrunk).collect(),
            options: *options,
        }
    }

    /// The photographs.
    #[must_use]
    pub fn photos(&self) -> &[Arc<GlassPhoto>] {
        &self.photos
    }

    /// All that its pictures depend on beside the seed and the frame: the hash of its files, and
    /// how they are used.
    #[must_use]
    pub fn facts(&self) -> Value {
        let OverlayOptions {
            params,
            gain,
            random,
        } = &self.options;
        json!({
            "sha256": self.sha256(),
            "n_photos": self.photos.len(),
            "background": params.background.map_or("auto", Background::name),
            "floor": params.floor,
            "gain": gain,
            "min_scale": random.map(|range| range.min_scale),
            "max_shift": random.map(|range| range.max_shift),
        })
    }

    /// SHA-256 over names and contents of all its files, hexadecimal.
    #[must_use]
    pub fn sha256(&self) -> String {
        let list: String = self
            .photos
            .iter()
            .map(|glass| format!("{} {}\n", glass.blake3, glass.name))
            .collect();
        sha256_hex(list.as_bytes())
    }

    /// A random part of a random photograph for a frame, by the seed.
    ///
    /// # Errors
    /// [`Error::Chain`] for a range that makes no sense, [`Error::NoPhotos`] for a set without any.
    pub fn draw(&self, frame: (u32, u32), seed: Seed) -> Result<PlacedPhoto, Error> {
        let mut rng = seed.stream(Stream::OverlayPlacement, 1);
        // Of 2^64 numbers, so that the remainder favors none.
        let n = self.photos.len() as u64;
        let place = usize::try_from(rng.next_u64() % n.max(1)).unwrap_or(0);
        match self.photos.get(place) {
            Some(glass) => Ok(glass.place(frame, &self.options, seed)?),
            None => Err(Error::NoPhotos {
                folder: Path::new("").to_owned(),
            }),
        }
    }
}

/// Shrunk to [`MOST_SIDE_PX`], if it is larger.
fn shrunk(mut glass: GlassPhoto) -> Arc<GlassPhoto> {
    glass.photo = glass.photo.shrunk_to(MOST_SIDE_PX);
    Arc::new(glass)
}

/// The PNG and JPEG files below a folder, in the order of their names.
pub(crate) fn photo_files(folder: &Path) -> Result<Vec<SourceImage>, Error> {
    let source =
        Source::open(&SourceSpec::new(SourceFormat::Folder, folder).following_links(true))?;
    let files: Vec<SourceImage> =
        source
            .images()
            .collect::<Result<_, _>>()
            .map_err(|bad| Error::BadPhoto {
                folder: folder.to_owned(),
                reason: bad.to_string(),
            })?;
    if files.is_empty() {
        return Err(Error::NoPhotos {
            folder: folder.to_owned(),
        });
    }
    Ok(files)
}

/// The photograph in a PNG or JPEG file.
///
/// # Errors
/// [`Error::Dataset`] if it cannot be read, [`Error::OfImage`] naming the file if it shows no
/// glass or its background cannot be told.
pub fn read_photo(path: &Path, params: &PhotoParams) -> Result<GlassPhoto, Error> {
    let name = path.file_name().unwrap_or(path.as_os_str());
    read_as(path, &name.to_string_lossy(), params)
}

fn read_as(path: &Path, name: &str, params: &PhotoParams) -> Result<GlassPhoto, Error> {
    let file = read_image(path, &ImageLimits::default())?;
    of_file(path, name, file, params)
}

/// The photograph in the bytes of such a file.
pub(crate) fn photo_of_bytes(
    name: &str,
    bytes: &[u8],
    params: &PhotoParams,
) -> Result<GlassPhoto, Error> {
    let file = decode_image(name, bytes, &ImageLimits::default())?;
    of_file(Path::new(name), name, file, params)
}

fn of_file(
    path: &Path,
    name: &str,
    file: ImageFile,
    params: &PhotoParams,
) -> Result<GlassPhoto, Error> {
    let photo =
        Photo::new(file.pixels, params).map_err(|error| Error::of_image(path, error.into()))?;
    Ok(GlassPhoto {
        photo,
        name: name.to_owned(),
        blake3: file.blake3,
    })
}
