//! How much memory a frame takes that is changed where it lies. Alone in its program: it counts what all threads take.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::print_stdout, reason = "figures of the documentation")]

use std::sync::Arc;

use peak_alloc::PeakAlloc;
use starbreak::optics::{Channels, FrameMut};
use starbreak::{Chain, Live, Recipe, Seed};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const SIZE: (u32, u32) = (1242, 375);

/// The most that some work takes at once beyond what there was, bytes.
fn taken(work: impl FnOnce()) -> usize {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    work();
    MEMORY.peak_usage() - before
}

#[test]
fn no_frame_is_allocated_once_one_was_seen() {
    let settings = Recipe::preset("windshield-spiderweb").unwrap();
    let chain = Chain::of(&settings.settings().unwrap(), SIZE, Seed(7)).unwrap();
    let chain = Arc::new(chain);
    for channels in [Channels::Bgra, Channels::Bgr, Channels::Rgb, Channels::Gray] {
        let n_bytes = SIZE.0 as usize * SIZE.1 as usize * channels.n_samples();
        let mut bytes: Vec<u8> = (0..n_bytes)
            .map(|k| u8::try_from(k * 7 % 251).unwrap())
            .collect();
        let mut live = Live::of(Arc::clone(&chain));
        let mut frame = FrameMut::of_bytes(&mut bytes, SIZE, channels).unwrap();
        let first = taken(|| live.over(&mut frame, Seed(0)).unwrap());
        // Each frame has another light, for it is what the last one left.
        let most = (1..20).map(|seed| taken(|| live.over(&mut frame, Seed(seed)).unwrap()));
        let most = most.max().unwrap();
        assert!(
            most < n_bytes / 4,
            "{channels:?}: {most} bytes for a frame of {n_bytes}; {first} for the first"
        );
        println!("{channels:?}: {most} bytes for a frame of {n_bytes}; {first} for the first");
    }
    // A model of the whole frame keeps its frame, and takes light for it anew.
    let settings = Recipe::preset("noise").unwrap();
    let chain = Chain::of(&settings.settings().unwrap(), SIZE, Seed(7)).unwrap();
    let mut live = Live::of(Arc::new(chain));
    let mut bytes = vec![90; SIZE.0 as usize * SIZE.1 as usize * 4];
    let n_bytes = bytes.len();
    let mut frame = FrameMut::of_bytes(&mut bytes, SIZE, Channels::Bgra).unwrap();
    let first = taken(|| live.over(&mut frame, Seed(0)).unwrap());
    let next = taken(|| live.over(&mut frame, Seed(1)).unwrap());
    assert!(
        first >= next + n_bytes / 2,
        "the kept frame is taken once: {first}, {next}"
    );
    println!("noise: {next} bytes for a frame of {n_bytes}; {first} for the first");
}
