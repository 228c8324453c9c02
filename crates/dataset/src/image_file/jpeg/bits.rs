//! Bits of compressed data, and the codes in them.

/// The bits up to the next marker.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The next `n_held` bits, from the highest on; zeros below.
    held: u64,
    n_held: u32,
}

impl<'a> Bits<'a> {
    /// From the beginning of `bytes`, which may go on beyond the marker.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            held: 0,
            n_held: 0,
        }
    }

    /// So many bits, 16 at most; nothing where fewer are left.
    #[inline]
    pub(super) fn take(&mut self, n: u32) -> Option<u32> {
        if self.n_held < n {
            self.refill();
        }
        self.n_held = self.n_held.checked_sub(n)?;
        // Two shifts, for a shift by 64 is none.
        let bits = u32::try_from((self.held >> 32) >> (32 - n)).unwrap_or(0);
        self.held <<= n;
        Some(bits)
    }

    /// The value of the next code; nothing where it is none, or ends behind the marker.
    #[inline]
    pub(super) fn code(&mut self, codes: &Codes) -> Option<u8> {
        if self.n_held < 16 {
            self.refill();
        }
        let next = u16::try_from(self.held >> 48).unwrap_or(0);
        let (n, value) = codes.find(next)?;
        self.n_held = self.n_held.checked_sub(n)?;
        self.held <<= n;
        Some(value)
    }

    /// Goes on behind a restart marker, where one is next.
    pub(super) fn pass_restart(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let marker = rest
            .windows(2)
            .position(|two| two[0] == 0xff && !matches!(two[1], 0 | 0xff));
        if let Some(marker) = marker
            && let Some(0xd0..=0xd7) = rest.get(marker + 1)
        {
            *self = Self::new(rest.get(marker + 2..).unwrap_or_default());
        }
    }

    fn refill(&mut self) {
        while self.n_held <= 56 {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let n_bytes = match rest {
                [0xff, 0, ..] => 2,
                [0xff, ..] | [] => return,
                _ => 1,
            };
            self.held |= u64::from(rest[0]) << (56 - self.n_held);
            self.n_held += 8;
            self.at += n_bytes;
        }
    }
}

/// Bits of a code that are looked up at once.
const N_SHORT: u32 = 9;

/// A Huffman table.
pub(super) struct Codes {
    /// Length and value of the code that so many bits begin with; length 0 where it is longer.
    short: Vec<(u8, u8)>,
    /// For each length: one beyond its last code, in 16 bits, and what to add to a code of this
    /// length to find its value.
    long: [(u32, i32); 17],
    values: Vec<u8>,
}

impl Codes {
    /// The first table of `bytes`, the numbers of codes of each length and the values, and how
    /// many bytes it takes; nothing where it is cut short or has more codes than there can be.
    pub(super) fn read(bytes: &[u8]) -> Option<(Self, usize)> {
        let (counts, rest) = bytes.split_first_chunk::<16>()?;
        let n_values = counts.iter().map(|n| usize::from(*n)).sum();
        let values = rest.get(..n_values)?.to_vec();
        let mut short = vec![(0, 0); 1 << N_SHORT];
        let mut long = [(0, 0); 17];
        let (mut code, mut n_before) = (0_u32, 0_u32);
        for (length, count) in (1_u8..).zip(counts) {
            let bits = u32::from(length);
            let count = u32::from(*count);
            if code + count > 1 << bits {
                return None;
            }
            if bits <= N_SHORT {
                let width = 1 << (N_SHORT - bits);
                let places = short
                    .chunks_exact_mut(width)
                    .skip(usize::try_from(code).ok()?);
                let of_length = values.get(usize::try_from(n_before).ok()?..)?;
                for (place, value) in places.zip(of_length).take(usize::try_from(count).ok()?) {
                    place.fill((length, *value));
                }
            }
            long[usize::from(length)] = (
                (code + count) << (16 - bits),
                i32::try_from(n_before).ok()? - i32::try_from(code).ok()?,
            );
            code = (code + count) << 1;
            n_before += count;
        }
        let codes = Self {
            short,
            long,
            values,
        };
        Some((codes, 16 + n_values))
    }

    /// Length and value of the code that these bits begin with.
    #[inline]
    fn find(&self, next: u16) -> Option<(u32, u8)> {
        if let Some((length @ 1.., value)) = self.short.get(usize::from(next >> (16 - N_SHORT))) {
            return Some((u32::from(*length), *value));
        }
        let next = u32::from(next);
        let length = (1..=16).find(|length| next < self.long[*length].0)?;
        let bits = u32::try_from(length).ok()?;
        let code = i32::try_from(next >> (16 - bits)).ok()?;
        let value = usize::try_from(code + self.long[length].1).ok()?;
        Some((bits, *self.values.get(value)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_all_lengths_are_found_and_nothing_behind_the_marker() {
        // One code of each length: 0, 10, 110, ...
        let mut table = vec![1; 16];
        table.extend(1..=16);
        let (codes, n_bytes) = Codes::read(&table).unwrap_or_else(|| panic!("a whole table"));
        assert_eq!(n_bytes, 32, "all bytes");
        for length in 1..=16_u8 {
            let code = u16::MAX.checked_shl(u32::from(17 - length)).unwrap_or(0);
            let bytes = [code.to_be_bytes()[0], 0, code.to_be_bytes()[1], 0];
            // An escape behind 0xff only.
            let bytes: Vec<u8> = match code {
                0xff00.. => bytes.to_vec(),
                _ => code.to_be_bytes().to_vec(),
            };
            assert_eq!(Bits::new(&bytes).code(&codes), Some(length), "{code:#b}");
        }
        for end in [&b""[..], b"\xff", b"\xff\xd9", b"\xff\xff\x00"] {
            let mut bits = Bits::new(end);
            assert_eq!(bits.take(1), None, "{end:?}");
            assert_eq!(bits.code(&codes), None, "{end:?}");
        }
        let mut bits = Bits::new(b"\xa5\xff\xd0\x0f");
        assert_eq!(bits.take(8), Some(0xa5), "before the restart");
        bits.pass_restart();
        assert_eq!(bits.take(8), Some(0x0f), "behind it");
    }

    #[test]
    fn more_codes_than_there_can_be_are_no_table() {
        let mut table = vec![0; 16];
        table[0] = 3;
        table.extend([1, 2, 3]);
        assert!(Codes::read(&table).is_none(), "three codes of one bit");
        assert!(Codes::read(&table[..10]).is_none(), "cut short");
    }
}
