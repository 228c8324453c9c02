//! Many images, side by side.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use image::RgbImage;
use starbreak_dataset::{ImageLimits, read_image};

use super::{Detector, ImageDetections};
use crate::DetectError;

/// An image to be looked through.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageToSee {
    /// Its name in its dataset.
    pub name: String,
    /// Where it can be read.
    pub path: PathBuf,
}

/// What a detector found in one image of many; `None` where it was stopped before.
pub type Seen = Option<Result<ImageDetections, DetectError>>;

impl Detector {
    /// What is found in each of many images, in their order.
    ///
    /// Each thread reads an image, looks through it and takes the next, so that not more images are
    /// held than there are threads; 0 threads stand for one per processor. The result does not
    /// depend on their number. Once `stop` is set no image is begun. `on_seen` is called after each
    /// image, by any thread, in any order.
    pub fn detect_all(
        &self,
        images: &[ImageToSee],
        n_threads: usize,
        stop: &AtomicBool,
        on_seen: &(dyn Fn(&ImageToSee, &Result<ImageDetections, DetectError>) + Sync),
    ) -> Vec<Seen> {
        let n_threads = match n_threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let next = AtomicUsize::new(0);
        // Threads of the system and no pool: a thread of a pool which waits for the model begins
        // another image meanwhile, and holds both.
        let work = || {
            let mut seen = Vec::new();
            while !stop.load(Ordering::Relaxed) {
                let place = next.fetch_add(1, Ordering::Relaxed);
                let Some(image) = images.get(place) else {
                    break;
                };
                let found = self.detect_file(image);
                on_seen(image, &found);
                seen.push((place, found));
            }
            seen
        };
        let mut all: Vec<Seen> = Vec::new();
        all.resize_with(images.len(), || None);
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..n_threads.min(images.len()))
                .map(|_| scope.spawn(work))
                .collect();
            for thread in threads {
                // Runtimes are guarded; what still panics is our own fault and is passed on.
                let seen = thread
                    .join()
                    .unwrap_or_else(|cause| std::panic::resume_unwind(cause));
                for (place, found) in seen {
                    if let Some(slot) = all.get_mut(place) {
                        *slot = Some(found);
                    }
                }
            }
        });
        all
    }

    /// What is found in each of the frames that `next` gives, in their order.
    ///
    /// Each thread takes a frame, looks through it and takes the next, so that not more frames are
    /// held than there are threads; 0 threads stand for one per processor. The result does not
    /// depend on their number. Once `stop` is set no frame is begun, and the frames end there.
    /// `on_seen` is called after each frame, by any thread, in any order.
    ///
    /// # Errors
    /// The first of `next`; what was found until then is lost.
    pub fn detect_frames(
        &self,
        next: impl FnMut() -> Result<Option<(String, RgbImage)>, DetectError> + Send,
        n_threads: usize,
        stop: &AtomicBool,
        on_seen: &(dyn Fn(&str, &Result<ImageDetections, DetectError>) + Sync),
    ) -> Result<Vec<Result<ImageDetections, DetectError>>, DetectError> {
        let n_threads = match n_threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        // The reader, and how many frames it has given; no more once it has failed or ended.
        let reader = Mutex::new((next, 0_usize, false));
        let work = || {
            let mut seen = Vec::new();
            while !stop.load(Ordering::Relaxed) {
                let (place, name, frame) = {
                    let mut guard = reader.lock().unwrap_or_else(PoisonError::into_inner);
                    let (next, n_given, has_ended) = &mut *guard;
                    if *has_ended {
                        break;
                    }
                    match next() {
                        Ok(Some((name, frame))) => {
                            let place = *n_given;
                            *n_given += 1;
                            (place, name, frame)
                        }
                        Ok(None) => {
                            *has_ended = true;
                            break;
                        }
                        Err(error) => {
                            *has_ended = true;
                            return Err(error);
                        }
                    }
                };
                let found = self.detect(&name, &frame);
                drop(frame);
                on_seen(&name, &found);
                seen.push((place, found));
            }
            Ok(seen)
        };
        let mut all = Vec::new();
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..n_threads).map(|_| scope.spawn(work)).collect();
            let mut failure = None;
            for thread in threads {
                let seen = thread
                    .join()
                    .unwrap_or_else(|cause| std::panic::resume_unwind(cause));
                match seen {
                    Ok(seen) => all.extend(seen),
                    Err(error) => failure = failure.take().or(Some(error)),
                }
            }
            failure.map_or(Ok(()), Err)
        })?;
        all.sort_by_key(|(place, _)| *place);
        Ok(all.into_iter().map(|(_, found)| found).collect())
    }

    /// What is found in the image of a file.
    ///
    /// # Errors
    ///
    /// [`DetectError::Dataset`] where it is no whole image, and those of [`Detector::detect`].
    pub(crate) fn detect_file(&self, image: &ImageToSee) -> Result<ImageDetections, DetectError> {
        let file = read_image(&image.path, &ImageLimits::default())?;
        self.detect(&image.name, &file.pixels.to_rgb8())
    }
}
