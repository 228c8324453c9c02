//! Raw frames with their own timestamps as a Matroska stream, which ffmpeg reads from a pipe.
//!
//! Bare frames have no timestamps, so that a clip of variable rate would lose its own. Of the
//! containers that carry them, this one is written without looking ahead.

/// The part of a stream before its frames.
///
/// Timestamps count nanoseconds. `frame_ns` is what a frame lasts by the nominal rate.
pub(super) fn head(width_px: u32, height_px: u32, frame_ns: u64) -> Vec<u8> {
    let file_type = [
        number(0x4286, 1),
        number(0x42F7, 1),
        number(0x42F2, 4),
        number(0x42F3, 8),
        element(0x4282, b"matroska"),
        number(0x4287, 4),
        number(0x4285, 2),
    ];
    let info = [
        number(0x2A_D7B1, 1),
        element(0x4D80, b"starbreak"),
        element(0x5741, b"starbreak"),
    ];
    let picture = [
        number(0xB0, u64::from(width_px)),
        number(0xBA, u64::from(height_px)),
        // Red, green and blue, 24 bits together.
        element(0x2E_B524, b"RGB\x18"),
    ];
    let track = [
        number(0xD7, 1),
        number(0x73C5, 1),
        number(0x83, 1),
        element(0x86, b"V_UNCOMPRESSED"),
        number(0x23_E383, frame_ns),
        element(0xE0, &picture.concat()),
    ];
    let track = element(0xAE, &track.concat());
    // A segment of unknown length: it goes on until the pipe is closed.
    let segment = [&id(0x1853_8067)[..], &[0x01], &[0xFF; 7]].concat();
    [
        element(0x1A45_DFA3, &file_type.concat()),
        segment,
        element(0x1549_A966, &info.concat()),
        element(0x1654_AE6B, &track),
    ]
    .concat()
}

/// What stands before the `n_bytes` of a frame that is shown at `time_ns`.
pub(super) fn before_frame(time_ns: u64, n_bytes: usize) -> Vec<u8> {
    // Track 1, no time beside the cluster's, a key frame.
    const BLOCK: [u8; 4] = [0x81, 0, 0, 0x80];
    let time = number(0xE7, time_ns);
    let block_id = id(0xA3);
    let n_block = (BLOCK.len() + n_bytes) as u64;
    let block_length = length(n_block);
    let n_cluster = (time.len() + block_id.len() + block_length.len()) as u64 + n_block;
    [
        &id(0x1F43_B675)[..],
        &length(n_cluster),
        &time,
        &block_id,
        &block_length,
        &BLOCK,
    ]
    .concat()
}

fn element(id_of: u32, content: &[u8]) -> Vec<u8> {
    [&id(id_of)[..], &length(content.len() as u64), content].concat()
}

fn number(id_of: u32, value: u64) -> Vec<u8> {
    element(id_of, &value.to_be_bytes())
}

/// An identifier without its leading zeros.
fn id(id_of: u32) -> Vec<u8> {
    let bytes = id_of.to_be_bytes();
    bytes.into_iter().skip_while(|byte| *byte == 0).collect()
}

/// A length in eight bytes, the first of which says so.
fn length(n_bytes: u64) -> [u8; 8] {
    (n_bytes | (1 << 56)).to_be_bytes()
}
