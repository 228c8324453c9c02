//! Threads, and how many.

use crate::Error;

/// Runs work on a pool of its own with `n_threads` threads; 0 stands for one per processor.
///
/// # Errors
/// [`Error::Threads`] if the system does not give them.
pub fn with_threads<R: Send>(
    n_threads: usize,
    work: impl FnOnce() -> R + Send,
) -> Result<R, Error> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(n_threads)
        .build()
        .map_err(|cause| Error::Threads {
            n_threads,
            cause: cause.to_string(),
        })?;
    Ok(pool.install(work))
}
