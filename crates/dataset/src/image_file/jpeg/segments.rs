//! The markers of a JPEG file and the segments behind them.

/// Markers in the order of the file, with their segments; compressed data are passed over.
pub(super) struct Segments<'a> {
    /// What follows the last segment.
    pub(super) rest: &'a [u8],
}

impl<'a> Segments<'a> {
    /// Of a whole file.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes.get(2..).unwrap_or_default(),
        }
    }
}

impl<'a> Iterator for Segments<'a> {
    type Item = (u8, &'a [u8]);

    /// The end-of-image marker with no segment, any other with its length bytes and what they
    /// count; nothing where the file ends before.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            // Compressed data, fill bytes and stray bytes between segments: up to the next marker.
            self.rest = self.rest.get(marker_at(self.rest)? + 1..)?;
            let marker = *self.rest.first()?;
            match marker {
                0xff => continue,
                0xd9 => return Some((marker, &[])),
                // An escaped 0xff, TEM, the restart markers and SOI have no segment.
                0x00 | 0x01 | 0xd0..=0xd8 => {
                    self.rest = self.rest.get(1..)?;
                    continue;
                }
                _ => {}
            }
            let [_, high, low, ..] = *self.rest else {
                return None;
            };
            let end = 1 + usize::from(u16::from_be_bytes([high, low]));
            let segment = self.rest.get(1..end)?;
            self.rest = self.rest.get(end..)?;
            return Some((marker, segment));
        }
    }
}

/// Place of the first 0xff.
pub(super) fn marker_at(bytes: &[u8]) -> Option<usize> {
    // Whole chunks without an early end, of which the compiler makes vectors.
    let (chunks, _) = bytes.as_chunks::<32>();
    let has_marker = |chunk: &[u8; 32]| chunk.iter().fold(false, |is, b| is | (*b == 0xff));
    let start = 32 * chunks.iter().take_while(|chunk| !has_marker(chunk)).count();
    let rest = bytes.get(start..)?;
    rest.iter().position(|b| *b == 0xff).map(|at| start + at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_are_found_wherever_they_lie() {
        for length in [0, 1, 31, 32, 33, 64, 100] {
            assert_eq!(marker_at(&vec![7; length]), None, "none in {length} bytes");
            for at in 0..length {
                let mut bytes = vec![0xfe; length];
                bytes[at..].fill(0xff);
                assert_eq!(marker_at(&bytes), Some(at), "{at} of {length} bytes");
            }
        }
    }
}
