//! Blocks read by AVX2, eight numbers at a time.

use std::arch::x86_64::{__m128i, __m256i};

use pulp::cast;
use pulp::x86::V3;

use super::block::{Block, Coded, GROUP, HALF_WIDTH, N_GROUPS, ROOM, Reader, are_in_range};

/// For each width, which of 16 bytes hold each of eight numbers: four bytes from the one in which
/// it begins, zero beyond the last.
static BYTES: [[u8; 32]; HALF_WIDTH + 1] = {
    let mut bytes = [[0; 32]; HALF_WIDTH + 1];
    let mut width = 0;
    while width <= HALF_WIDTH {
        let mut k = 0;
        while k < 32 {
            let byte = k / 4 * width / 8 + k % 4;
            #[expect(clippy::cast_possible_truncation, reason = "below 16")]
            let byte = if byte < 16 { byte as u8 } else { 0x80 };
            bytes[width][k] = byte;
            k += 1;
        }
        width += 1;
    }
    bytes
};

/// The bit of those bytes that each number begins with.
static BITS: [[u32; GROUP]; HALF_WIDTH + 1] = {
    let mut bits = [[0; GROUP]; HALF_WIDTH + 1];
    let mut width = 0;
    while width <= HALF_WIDTH {
        let mut k = 0;
        while k < GROUP {
            #[expect(clippy::cast_possible_truncation, reason = "below 8")]
            let bit = (k * width % 8) as u32;
            bits[width][k] = bit;
            k += 1;
        }
        width += 1;
    }
    bits
};

impl Reader for V3 {
    #[inline(always)]
    fn unpack_small(self, room: &[u8; ROOM], at: usize, width: usize, group: &mut [u32; GROUP]) {
        const {
            assert!(
                (N_GROUPS - 1) * HALF_WIDTH + 16 <= ROOM,
                "room for the last group"
            )
        };
        let window: [u8; 16] = room[at.min(ROOM - 16)..]
            .first_chunk()
            .copied()
            .unwrap_or_default();
        let width = width.min(HALF_WIDTH);
        let window = self
            .avx2
            ._mm256_broadcastsi128_si256(cast::<_, __m128i>(window));
        let bytes = self.avx2._mm256_shuffle_epi8(window, cast(BYTES[width]));
        let shifted = self.avx2._mm256_srlv_epi32(bytes, cast(BITS[width]));
        let lowest = self.avx._mm256_set1_epi32((1 << width) - 1);
        *group = cast(self.avx2._mm256_and_si256(shifted, lowest));
    }

    #[inline(always)]
    fn restore(self, coded: &Coded, block: &mut Block) -> bool {
        let Self { avx, avx2, .. } = self;
        let (is_summed, is_above) = coded.masks();
        let is_summed = avx._mm256_set1_epi32(is_summed);
        let is_above = avx._mm256_set1_epi32(is_above);
        let (one, last) = (avx._mm256_set1_epi32(1), avx._mm256_set1_epi32(7));
        let mut before = avx._mm256_setzero_si256();
        let mut any = before;
        let coded = coded.zigzag.as_chunks::<GROUP>().0;
        let values = block.as_chunks_mut::<GROUP>().0;
        for (values, coded) in values.iter_mut().zip(coded) {
            let coded: __m256i = cast(*coded);
            let odd = avx2._mm256_and_si256(coded, one);
            let sign = avx2._mm256_sub_epi32(avx._mm256_setzero_si256(), odd);
            let differences = avx2._mm256_xor_si256(avx2._mm256_srli_epi32::<1>(coded), sign);
            // Running sums of each half, then those of the second on top of the first's last.
            let pairs =
                avx2._mm256_add_epi32(differences, avx2._mm256_slli_si256::<4>(differences));
            let halves = avx2._mm256_add_epi32(pairs, avx2._mm256_slli_si256::<8>(pairs));
            let first = avx2._mm256_permute2x128_si256::<0x08>(halves, halves);
            let sums = avx2._mm256_add_epi32(halves, avx2._mm256_shuffle_epi32::<0xff>(first));
            let sums = avx2._mm256_add_epi32(sums, before);
            before = avx2._mm256_and_si256(avx2._mm256_permutevar8x32_epi32(sums, last), is_summed);
            let own = avx2._mm256_blendv_epi8(differences, sums, is_summed);
            let above = avx2._mm256_and_si256(cast(*values), is_above);
            let restored = avx2._mm256_add_epi32(own, above);
            any = avx2._mm256_or_si256(any, avx2._mm256_abs_epi32(restored));
            *values = cast(restored);
        }
        are_in_range::<GROUP>(cast(any))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::TestRunner;

    use super::super::block::{AnyProcessor, MOST, read_block, write_block};
    use super::super::bytes::Bytes;
    use super::*;
    use crate::maps::CHUNK;

    #[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
    fn avx2() -> Option<V3> {
        let avx2 = V3::try_new();
        if avx2.is_none() {
            eprintln!("SKIPPED: this processor has no AVX2");
        }
        avx2
    }

    fn read(reader: impl Reader, bytes: &[u8]) -> Result<Coded, TestCaseError> {
        let mut coded = Coded::NOTHING;
        read_block(reader, &mut Bytes::new("block", bytes), &mut coded)
            .map_err(|error| TestCaseError::fail(error.to_string()))?;
        Ok(coded)
    }

    /// Both read the same out of some bytes, and make the same of it on top of some numbers.
    fn agree(avx2: V3, bytes: &[u8], on: &Block) -> Result<(), TestCaseError> {
        let (one, all) = (read(AnyProcessor, bytes), read(avx2, bytes));
        prop_assert_eq!(one.is_ok(), all.is_ok(), "whether it is a block");
        let (Ok(one), Ok(all)) = (one, all) else {
            return Ok(());
        };
        prop_assert_eq!(one.zigzag, all.zigzag, "differences");
        let (mut by_one, mut by_all) = (*on, *on);
        let are_in_range = AnyProcessor.restore(&one, &mut by_one);
        prop_assert_eq!(avx2.restore(&all, &mut by_all), are_in_range, "range");
        prop_assert_eq!(by_one, by_all, "restored");
        Ok(())
    }

    /// Numbers of so many bits at most.
    fn numbers(n_bits: u32) -> impl Strategy<Value = Block> {
        prop::array::uniform32(-(1 << n_bits)..1 << n_bits)
    }

    #[test]
    fn blocks_are_those_that_any_processor_reads() {
        let Some(avx2) = avx2() else { return };
        let blocks = (0_u32..24).prop_flat_map(|n_bits| (numbers(n_bits), numbers(n_bits)));
        // Also on top of numbers that a block was not written for.
        let cases = (blocks, 0..=CHUNK, numbers(25));
        let checked =
            TestRunner::default().run(&cases, |((mut block, above), n_like_above, on)| {
                // So that differences to the row above are small, too.
                block[..n_like_above].copy_from_slice(&above[..n_like_above]);
                let mut bytes = Vec::new();
                write_block(&mut bytes, &block, &above);
                // Room to look at sixteen bytes at once.
                bytes.extend([0xa5; ROOM]);
                let mut restored = above;
                prop_assert!(
                    avx2.restore(&read(avx2, &bytes)?, &mut restored),
                    "in range"
                );
                prop_assert_eq!(restored, block, "as it was written");
                agree(avx2, &bytes, &on)
            });
        assert!(checked.is_ok(), "{checked:?}");
    }

    #[test]
    fn damaged_blocks_are_those_that_any_processor_reads() {
        let Some(avx2) = avx2() else { return };
        let bytes = prop::collection::vec(any::<u8>(), 0..200);
        let checked = TestRunner::default().run(&(bytes, numbers(25)), |(bytes, on)| {
            agree(avx2, &bytes, &on)
        });
        assert!(checked.is_ok(), "{checked:?}");
    }

    #[test]
    fn a_number_that_is_too_large_is_told() -> Result<(), TestCaseError> {
        let Some(avx2) = avx2() else { return Ok(()) };
        let above: Block = std::array::from_fn(|k| if k % 2 == 0 { 1000 } else { -1000 });
        let mut bytes = Vec::new();
        write_block(&mut bytes, &above.map(|above| above + 1), &above);
        bytes.extend([0; ROOM]);
        let coded = read(avx2, &bytes)?;
        for (most, expected) in [(MOST - 1, true), (MOST, false)] {
            for k in [0, 7, 8, 31] {
                let mut block = [0; CHUNK];
                block[k] = most;
                prop_assert_eq!(
                    avx2.restore(&coded, &mut block),
                    expected,
                    "{} at {}",
                    most,
                    k
                );
            }
        }
        Ok(())
    }
}
