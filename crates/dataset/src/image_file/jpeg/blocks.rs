//! Whether all blocks of a JPEG file are there.
//!
//! The decoder paints what is missing in gray, and says nothing where an end marker stands too
//! early. Here the codes are read once more, without their numbers, and counted.

use super::bits::{Bits, Codes};
use super::segments::Segments;

/// What is missing of the pixels of a file that is otherwise good, or nothing.
pub(super) fn missing(bytes: &[u8]) -> Option<String> {
    let mut tables = Tables::default();
    let mut frame: Option<Frame> = None;
    let mut segments = Segments::new(bytes);
    while let Some((marker, segment)) = segments.next() {
        match (marker, &mut frame) {
            (0xc4, _) => tables.read(segment.get(2..).unwrap_or_default()),
            (0xc0..=0xc2, _) => frame = Some(Frame::read(segment, marker == 0xc2)?),
            (0xdd, _) => {
                let [_, _, high, low, ..] = *segment else {
                    continue;
                };
                tables.n_to_restart = usize::from(u16::from_be_bytes([high, low]));
            }
            (0xda, Some(frame)) => {
                let Some(scan) = Scan::read(segment, frame) else {
                    return Some("one of its scans has a header that means nothing".to_owned());
                };
                let (n_read, n_blocks) = scan.count(frame, &tables, segments.rest);
                if n_read < n_blocks {
                    return Some(format!(
                        "its pixels end after {n_read} of {n_blocks} blocks of 8 x 8"
                    ));
                }
            }
            (0xd9, _) => break,
            _ => {}
        }
    }
    let is_whole = |part: &Component| part.bits_to_come == [0; 64];
    let frame = frame?;
    (!frame.components.iter().all(is_whole))
        .then(|| "it ends before the last scan of its pixels".to_owned())
}

/// Codes and restarts as they stand before a scan.
#[derive(Default)]
struct Tables {
    dc: [Option<Codes>; 4],
    ac: [Option<Codes>; 4],
    /// MCUs between restart markers; 0 for none.
    n_to_restart: usize,
}

impl Tables {
    fn read(&mut self, mut bytes: &[u8]) {
        while let Some((kind, rest)) = bytes.split_first()
            && let Some((codes, n_bytes)) = Codes::read(rest)
        {
            let tables = if kind >> 4 == 0 {
                &mut self.dc
            } else {
                &mut self.ac
            };
            if let Some(place) = tables.get_mut(usize::from(kind & 15)) {
                *place = Some(codes);
            }
            bytes = rest.get(n_bytes..).unwrap_or_default();
        }
    }
}

/// One of the channels.
struct Component {
    id: u8,
    /// Blocks of one MCU, across and down.
    in_mcu: [usize; 2],
    /// Blocks with pixels of the image.
    n_blocks: [usize; 2],
    /// Blocks in a row of MCUs.
    stride: usize,
    /// For each coefficient, how many of its low bits are still to come; 255 for all.
    bits_to_come: [u8; 64],
    /// For each block, which coefficients are not zero, one bit for each.
    nonzero: Vec<u64>,
}

struct Frame {
    /// Coefficients come in several passes.
    is_progressive: bool,
    components: Vec<Component>,
    n_mcus: [usize; 2],
}

impl Frame {
    fn read(segment: &[u8], is_progressive: bool) -> Option<Self> {
        let [_, _, _, h0, h1, w0, w1, n, parts @ ..] = segment else {
            return None;
        };
        let side = |high: &u8, low: &u8| usize::from(u16::from_be_bytes([*high, *low]));
        let size_px = [side(w0, w1), side(h0, h1)];
        let (parts, _) = parts.as_chunks::<3>();
        let parts = parts.get(..usize::from(*n))?;
        let factors = |sampling: u8| [usize::from(sampling >> 4), usize::from(sampling & 15)];
        let mut largest = [1, 1];
        for [_, sampling, _] in parts {
            let factors = factors(*sampling);
            largest = [largest[0].max(factors[0]), largest[1].max(factors[1])];
        }
        let n_mcus = [0, 1].map(|axis| size_px[axis].div_ceil(8 * largest[axis]));
        let component = |[id, sampling, _]: &[u8; 3]| {
            let in_mcu = factors(*sampling);
            let blocks = |axis: usize| {
                let side_px = (size_px[axis] * in_mcu[axis]).div_ceil(largest[axis]);
                side_px.div_ceil(8)
            };
            Component {
                id: *id,
                in_mcu,
                n_blocks: [blocks(0), blocks(1)],
                stride: n_mcus[0] * in_mcu[0],
                bits_to_come: [255; 64],
                nonzero: Vec::new(),
            }
        };
        Some(Self {
            is_progressive,
            components: parts.iter().map(component).collect(),
            n_mcus,
        })
    }
}

/// A pass over some components.
struct Scan {
    /// Index of the component, and of its tables.
    parts: Vec<(usize, usize, usize)>,
    pass: Pass,
    /// First and last coefficient.
    band: [u8; 2],
}

/// What a pass brings.
#[derive(Clone, Copy, PartialEq)]
enum Pass {
    /// All of a block.
    Whole,
    FirstDc,
    NextBitOfDc,
    FirstAc,
    NextBitOfAc,
}

impl Scan {
    /// What a scan header says; the components then know which of their bits have come.
    fn read(segment: &[u8], frame: &mut Frame) -> Option<Self> {
        let (&n, rest) = segment.get(2..)?.split_first()?;
        let (chosen, rest) = rest.split_at_checked(2 * usize::from(n))?;
        // What else stands there is not read for other frames.
        let [first, last, bits] = match (rest, frame.is_progressive) {
            ([first, last, bits, ..], true) => [*first, *last, *bits],
            _ => [0, 63, 0],
        };
        let (chosen, _) = chosen.as_chunks::<2>();
        let index = |id: u8| frame.components.iter().position(|part| part.id == id);
        let parts: Vec<_> = chosen
            .iter()
            .map(|[id, tables]| {
                Some((
                    index(*id)?,
                    usize::from(tables >> 4),
                    usize::from(tables & 15),
                ))
            })
            .collect::<Option<_>>()?;
        let pass = match (first, last, bits >> 4) {
            _ if !frame.is_progressive => Pass::Whole,
            (0, _, 0) => Pass::FirstDc,
            (0, ..) => Pass::NextBitOfDc,
            (_, _, 0) => Pass::FirstAc,
            _ => Pass::NextBitOfAc,
        };
        let is_ac = matches!(pass, Pass::FirstAc | Pass::NextBitOfAc);
        if last > 63 || first > last || parts.is_empty() || (is_ac && parts.len() != 1) {
            return None;
        }
        for (part, ..) in &parts {
            let part = frame.components.get_mut(*part)?;
            part.bits_to_come[usize::from(first)..=usize::from(last)].fill(bits & 15);
            if is_ac && part.nonzero.is_empty() {
                let n_rows = frame.n_mcus[1] * part.in_mcu[1];
                part.nonzero = vec![0; part.stride * n_rows];
            }
        }
        Some(Self {
            parts,
            pass,
            band: [first, last],
        })
    }

    /// How many blocks are there, and how many belong there.
    fn count(&self, frame: &mut Frame, tables: &Tables, bytes: &[u8]) -> (usize, usize) {
        let mut reader = BlockReader {
            bits: Bits::new(bytes),
            n_empty: 0,
        };
        let (sides, in_mcu) = match self.parts[..] {
            // One component has no MCUs but its own blocks.
            [(part, ..)] => (frame.components[part].n_blocks, vec![[1, 1]]),
            _ => {
                let in_mcu = self
                    .parts
                    .iter()
                    .map(|(part, ..)| frame.components[*part].in_mcu);
                (frame.n_mcus, in_mcu.collect())
            }
        };
        let blocks_in_mcu: usize = in_mcu.iter().map(|n| n[0] * n[1]).sum();
        let n_blocks = sides[0] * sides[1] * blocks_in_mcu;
        let mut n_read = 0;
        for mcu in 0..sides[0] * sides[1] {
            if tables.n_to_restart > 0 && mcu > 0 && mcu.is_multiple_of(tables.n_to_restart) {
                reader.bits.pass_restart();
                reader.n_empty = 0;
            }
            let (row, column) = (mcu / sides[0], mcu % sides[0]);
            for ((part, dc, ac), in_mcu) in self.parts.iter().zip(&in_mcu) {
                let codes = [tables.dc.get(*dc), tables.ac.get(*ac)].map(|codes| codes?.as_ref());
                let part = &mut frame.components[*part];
                for k in 0..in_mcu[0] * in_mcu[1] {
                    let y = row * in_mcu[1] + k / in_mcu[0];
                    let x = column * in_mcu[0] + k % in_mcu[0];
                    let nonzero = part.nonzero.get_mut(y * part.stride + x);
                    if reader.block(self, codes, nonzero).is_none() {
                        return (n_read, n_blocks);
                    }
                    n_read += 1;
                }
            }
        }
        (n_read, n_blocks)
    }
}

/// Codes of Huffman's for the first coefficient and for the others.
type BlockCodes<'a> = [Option<&'a Codes>; 2];

struct BlockReader<'a> {
    bits: Bits<'a>,
    /// Blocks to come without new coefficients.
    n_empty: u32,
}

impl BlockReader<'_> {
    /// Passes over a block; nothing where it is not there or its codes are none.
    fn block(
        &mut self,
        scan: &Scan,
        [dc, ac]: BlockCodes<'_>,
        nonzero: Option<&mut u64>,
    ) -> Option<()> {
        match scan.pass {
            Pass::Whole => {
                self.number(dc?)?;
                self.all_others(ac?)
            }
            Pass::FirstDc => self.number(dc?),
            Pass::NextBitOfDc => self.bits.take(1).map(drop),
            Pass::FirstAc => self.first_ac(scan.band, ac?, nonzero?),
            Pass::NextBitOfAc => self.next_bit_of_ac(scan.band, ac?, nonzero?),
        }
    }

    /// A code for a length, and a number of that length.
    fn number(&mut self, codes: &Codes) -> Option<()> {
        let length = self.bits.code(codes)?;
        self.bits.take(u32::from(length).min(16)).map(drop)
    }

    fn all_others(&mut self, codes: &Codes) -> Option<()> {
        let mut k = 1;
        while k < 64 {
            let code = self.bits.code(codes)?;
            let (run, length) = (code >> 4, code & 15);
            if length == 0 && run < 15 {
                break;
            }
            self.bits.take(u32::from(length))?;
            k += u32::from(run) + 1;
        }
        Some(())
    }

    fn first_ac(&mut self, [first, last]: [u8; 2], codes: &Codes, nonzero: &mut u64) -> Option<()> {
        if self.n_empty > 0 {
            self.n_empty -= 1;
            return Some(());
        }
        let mut k = first;
        while k <= last {
            let code = self.bits.code(codes)?;
            let (run, length) = (code >> 4, code & 15);
            if length == 0 && run < 15 {
                self.n_empty = (1 << run) - 1 + self.bits.take(u32::from(run))?;
                break;
            }
            self.bits.take(u32::from(length))?;
            k += run;
            if length > 0 && k < 64 {
                *nonzero |= 1 << k;
            }
            k += 1;
        }
        Some(())
    }

    /// One more bit of every coefficient that is not zero, and new ones between them.
    fn next_bit_of_ac(
        &mut self,
        [first, last]: [u8; 2],
        codes: &Codes,
        nonzero: &mut u64,
    ) -> Option<()> {
        let mut k = first;
        while self.n_empty == 0 && k <= last {
            let code = self.bits.code(codes)?;
            let (mut run, length) = (code >> 4, code & 15);
            if length == 0 && run < 15 {
                self.n_empty = (1 << run) + self.bits.take(u32::from(run))?;
                break;
            }
            if length > 0 {
                // Its sign.
                self.bits.take(1)?;
            }
            while k <= last {
                if *nonzero >> k & 1 == 1 {
                    self.bits.take(1)?;
                } else if run == 0 {
                    break;
                } else {
                    run -= 1;
                }
                k += 1;
            }
            if length > 0 && k <= last {
                *nonzero |= 1 << k;
            }
            k += 1;
        }
        if self.n_empty > 0 {
            self.n_empty -= 1;
            for k in k..=last {
                self.bits.take(u32::from(*nonzero >> k & 1 == 1))?;
            }
        }
        Some(())
    }
}
