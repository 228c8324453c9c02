//! How long the file of a clip says that it is: a cut between two packets is nothing to ffmpeg.

use std::io::{self, Read, Seek, SeekFrom};

/// Boxes that stand at the top of an MP4 or QuickTime file.
const TOP_BOXES: [&[u8; 4]; 14] = [
    b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot", b"udta", b"meta", b"moof",
    b"mfra", b"sidx", b"styp", b"uuid",
];

/// Where the file ends by what it says of itself, bytes, if its container says so and that is beyond where it
/// ends: an AVI file by its header, an MP4 or QuickTime file by its boxes.
pub(super) fn missing_end(file: &mut (impl Read + Seek), n_bytes: u64) -> io::Result<Option<u64>> {
    let mut at = 0_u64;
    loop {
        file.seek(SeekFrom::Start(at))?;
        let mut head = Vec::new();
        file.by_ref().take(16).read_to_end(&mut head)?;
        match riff_end(&head)
            .filter(|_| at == 0)
            .or_else(|| box_end(&head, at))
        {
            Some(end) if end > n_bytes => return Ok(Some(end)),
            // Behind an AVI file stands no box, and behind the last box nothing.
            Some(end) => at = end,
            None => return Ok(None),
        }
    }
}

/// Where an AVI file ends, by its first twelve bytes.
fn riff_end(head: &[u8]) -> Option<u64> {
    let (name, rest) = head.split_first_chunk::<4>()?;
    let (n_bytes, kind) = rest.split_first_chunk::<4>()?;
    let is_avi = name == b"RIFF" && kind.starts_with(b"AVI ");
    is_avi.then(|| u64::from(u32::from_le_bytes(*n_bytes)) + 8)
}

/// Where a box that begins `at` this place ends, by its first bytes; none for one that goes on to the end of the
/// file, and for what is no box.
fn box_end(head: &[u8], at: u64) -> Option<u64> {
    let (n_bytes, rest) = head.split_first_chunk::<4>()?;
    let (kind, rest) = rest.split_first_chunk::<4>()?;
    if !TOP_BOXES.contains(&kind) {
        return None;
    }
    let n_bytes = match u32::from_be_bytes(*n_bytes) {
        1 => u64::from_be_bytes(*rest.first_chunk()?),
        n => u64::from(n),
    };
    (n_bytes >= 8).then(|| at.saturating_add(n_bytes))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use std::io::Cursor;

    use super::missing_end;

    fn top_box(kind: &[u8; 4], n_inside: usize) -> Vec<u8> {
        let n_bytes = u32::try_from(n_inside + 8).unwrap();
        [&n_bytes.to_be_bytes()[..], kind, &vec![0; n_inside]].concat()
    }

    fn missing(bytes: &[u8]) -> Option<u64> {
        missing_end(&mut Cursor::new(bytes), bytes.len() as u64).unwrap()
    }

    #[test]
    fn every_cut_of_an_mp4_within_a_box_is_seen() {
        let mut large = top_box(b"mdat", 48);
        large[..4].copy_from_slice(&1_u32.to_be_bytes());
        large[8..16].copy_from_slice(&56_u64.to_be_bytes());
        // Boxes with the lengths of their headers.
        let boxes = [
            (top_box(b"ftyp", 24), 8),
            (large, 16),
            (top_box(b"moov", 100), 8),
        ];
        let mut whole = Vec::new();
        for (one, n_header) in boxes {
            let (begin, end) = (whole.len(), whole.len() + one.len());
            whole.extend(one);
            assert_eq!(missing(&whole), None, "whole");
            for n in begin..end {
                // Of a header that is cut itself nothing is known, and ffmpeg misses the index.
                let expected = (n >= begin + n_header).then_some(end as u64);
                assert_eq!(missing(&whole[..n]), expected, "{n} bytes");
            }
        }
    }

    #[test]
    fn what_is_no_box_or_has_no_length_is_left_to_ffmpeg() {
        let mut open = top_box(b"mdat", 100);
        open[..4].copy_from_slice(&0_u32.to_be_bytes());
        let file = [top_box(b"ftyp", 24), open].concat();
        assert_eq!(missing(&file), None, "up to the end, whichever it is");
        let padded = [top_box(b"ftyp", 24), top_box(b"moov", 9), vec![0; 100]].concat();
        assert_eq!(missing(&padded), None, "zeros behind the last box");
        assert_eq!(missing(b"\x1aE\xdf\xa3 a Matroska file"), None);
        assert_eq!(missing(b"RIFF\x08\x01\0\0AVI LIST"), Some(272), "an AVI");
        assert_eq!(missing(b"RIFF\x08\x01\0\0WAVE"), None, "a sound");
        assert_eq!(missing(b"RIFF\x08"), None, "a stump");
    }
}
