//! A baked pattern as bytes, and what is made of them.
//!
//! Version, frame, focal length, layers; then of each layer its light and its tint, each after its
//! length in bytes; then the crack mask.

use std::ops::Range;

use image::GrayImage;

use super::block::{AnyProcessor, Block, Reader};
use super::bytes::{Bytes, write_count};
use super::runs::{BlockRun, RunReader, from_steps, steps, write_runs};
use super::values::{light_blocks, light_pixels, tint_blocks, tint_pixels};
use super::{MAX_PIXELS, MAX_SIDE_PX};
use crate::OpticsError;
use crate::environment::Environment;
use crate::maps::{CHUNK, LaneRun, LaneRuns};
use crate::physical::{
    Colors, Lighting, Outline, Overlay, OverlayLayer, Pattern, PatternLayer, PhysicalOptics,
    code_mask,
};
use crate::surface::LANES;

/// First byte; another one is another version.
const VERSION: u8 = 4;

/// What errors call it.
const WHAT: &str = "pattern";

/// Layers that a pattern may have.
const MAX_LAYERS: usize = 16;

impl Pattern {
    /// The pattern as bytes, a twentieth or so of its size in memory.
    ///
    /// A picture made from a [`PackedPattern`] of them differs from one made from this pattern by
    /// at most one code of 8 bits, in few pixels; so for pictures that are to be equal,
    /// all are made from the packed form. Packing what was unpacked gives the same bytes, in frames of up
    /// to 8192 px per side.
    #[must_use]
    pub fn to_packed(&self) -> Vec<u8> {
        let (width, height) = self.size();
        let mut out = vec![VERSION];
        write_count(&mut out, width as usize);
        write_count(&mut out, height as usize);
        out.extend_from_slice(&self.f_px().to_le_bytes());
        write_count(&mut out, self.layers().len());
        for layer in self.layers() {
            let [mut light, mut tint] = [Vec::new(), Vec::new()];
            write_chunks(&mut light, &layer.light, light_blocks);
            write_chunks(&mut tint, &layer.tint, tint_blocks);
            for part in [light, tint] {
                write_count(&mut out, part.len());
                out.extend(part);
            }
        }
        match self.outline() {
            Outline::Corners(_) => write_mask(&mut out, &self.coverage()),
            Outline::Codes(codes) => write_chunks(&mut out, codes, |_, run| {
                [run[0].map(|code| steps(code, 1.0))]
            }),
        }
        out
    }
}

/// A [`Pattern`] in the bytes of [`Pattern::to_packed`].
///
/// They are given light as they are read, run by run: the fastest way to one image.
#[derive(Debug, Clone)]
pub struct PackedPattern {
    bytes: Vec<u8>,
    size: (u32, u32),
    f_px: f64,
    layers: Vec<PackedLayer>,
    /// Where the mask is.
    mask: Range<usize>,
}

/// Where the parts of a layer are.
#[derive(Debug, Clone)]
struct PackedLayer {
    light: Range<usize>,
    tint: Range<usize>,
}

impl PackedPattern {
    /// The pattern in some bytes, of which the head is read.
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which they are wrong.
    pub fn new(bytes: Vec<u8>) -> Result<Self, OpticsError> {
        let mut head = Bytes::new(WHAT, &bytes);
        if head.byte()? != VERSION {
            return Err(head.wrong("it is of another version"));
        }
        let width = head.count(MAX_SIDE_PX)?;
        let height = head.count(MAX_SIDE_PX)?;
        if width * height > MAX_PIXELS {
            return Err(head.wrong("its frame is too large"));
        }
        let f_px = f64::from_le_bytes(head.take()?);
        if !(f_px.is_finite() && f_px > 0.0) {
            return Err(head.wrong("its focal length is no length"));
        }
        let n_layers = head.count(MAX_LAYERS)?;
        let mut layers = Vec::with_capacity(n_layers);
        for _ in 0..n_layers {
            layers.push(PackedLayer {
                light: head.part()?,
                tint: head.part()?,
            });
        }
        let mask = head.at()..bytes.len();
        Ok(Self {
            size: (side(width), side(height)),
            f_px,
            layers,
            mask,
            bytes,
        })
    }

    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Focal length of the camera, px.
    #[must_use]
    pub fn f_px(&self) -> f64 {
        self.f_px
    }

    /// Whether nothing of a crack is in the frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.layers.is_empty()
    }

    /// As [`Pattern::light`] of the pattern.
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which the bytes are wrong.
    pub fn light(
        &self,
        environment: &Environment,
        optics: &PhysicalOptics,
    ) -> Result<Overlay, OpticsError> {
        let layers = self.layers.iter();
        let colors = Colors::of(environment, &optics.glass);
        let layers = layers.map(|layer| self.lit(layer, &colors));
        Ok(Overlay::of_layers(
            (self.size, self.f_px),
            environment,
            optics,
            layers.collect::<Result<_, _>>()?,
        ))
    }

    fn lit(&self, layer: &PackedLayer, colors: &Colors) -> Result<OverlayLayer, OpticsError> {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = pulp::x86::V3::try_new() {
            return avx2.vectorize(LitByAvx2 {
                avx2,
                pattern: self,
                layer,
                colors,
            });
        }
        self.lit_by(AnyProcessor, layer, colors)
    }

    #[inline(always)]
    fn lit_by(
        &self,
        reader: impl Reader,
        layer: &PackedLayer,
        colors: &Colors,
    ) -> Result<OverlayLayer, OpticsError> {
        let mut runs = self.runs::<LANES>(&layer.light)?;
        let mut tints = self.runs::<3>(&layer.tint)?;
        let mut lighting = Lighting::new(*colors, runs.n_left(), OverlayLayer::default());
        let (mut lanes, mut colors) = ([[0.0; CHUNK]; LANES], [[0.0; CHUNK]; 3]);
        while let Some(run) = runs.next(reader)? {
            let BlockRun { at, present, .. } = run;
            let (x, y) = at;
            light_pixels(&run, &mut lanes);
            let mut is_tinted = false;
            while !is_tinted
                && tints
                    .at()
                    .is_some_and(|(tint_x, tint_y)| (tint_y, tint_x) <= (y, x))
            {
                if let Some(tint) = tints.next(reader)? {
                    is_tinted = tint.at == at;
                    tint_pixels(&tint, &mut colors);
                }
            }
            lighting.push(at, (&lanes, present), is_tinted.then_some(&colors));
        }
        while tints.next(reader)?.is_some() {}
        let (width, height) = self.size;
        Ok(lighting.into_layer((width as usize, height as usize)))
    }

    /// As [`Pattern::coverage`] of the pattern.
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which the bytes are wrong.
    pub fn coverage(&self) -> Result<GrayImage, OpticsError> {
        Ok(code_mask(self.size, &self.codes()?))
    }

    /// The pattern itself, to be lit again and again.
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which the bytes are wrong.
    pub fn unpack(&self) -> Result<Pattern, OpticsError> {
        let layers = self.layers.iter().map(|layer| {
            Ok(PatternLayer {
                light: self.lane_runs(&layer.light, light_pixels)?,
                tint: self.lane_runs(&layer.tint, tint_pixels)?,
                has_drops: false,
            })
        });
        Ok(Pattern::from_parts(
            self.size,
            self.f_px,
            layers.collect::<Result<_, OpticsError>>()?,
            Outline::Codes(self.codes()?),
        ))
    }

    fn codes(&self) -> Result<LaneRuns<1>, OpticsError> {
        self.lane_runs(&self.mask, |of: &BlockRun<'_, 1>, [run]| {
            let [codes] = of.blocks;
            let width = self.size.0 as usize;
            for ((lane, code), _) in run.iter_mut().zip(codes).zip(of.at.0..width) {
                *lane = from_steps((*code).clamp(0, 255), 1.0);
            }
        })
    }

    /// Reads what [`write_chunks`] wrote.
    fn lane_runs<const B: usize, const L: usize>(
        &self,
        part: &Range<usize>,
        pixels: impl Fn(&BlockRun<'_, B>, &mut LaneRun<L>),
    ) -> Result<LaneRuns<L>, OpticsError> {
        let mut reader = self.runs::<B>(part)?;
        let (width, height) = self.size;
        let mut runs = LaneRuns::with_room(width as usize, height as usize, reader.n_left());
        while let Some(run) = reader.next(AnyProcessor)? {
            pixels(&run, runs.push(run.at));
        }
        Ok(runs)
    }

    fn runs<const B: usize>(&self, part: &Range<usize>) -> Result<RunReader<'_, B>, OpticsError> {
        let (width, height) = self.size;
        let bytes = Bytes::of_part(WHAT, &self.bytes, part);
        RunReader::new(bytes, (width as usize, height as usize))
    }
}

/// [`PackedPattern::lit_by`], compiled once more for processors with AVX2 as far as it is inlined,
/// which a closure would not be. No result depends on it: nothing is fused or summed in another
/// order.
#[cfg(target_arch = "x86_64")]
struct LitByAvx2<'a> {
    avx2: pulp::x86::V3,
    pattern: &'a PackedPattern,
    layer: &'a PackedLayer,
    colors: &'a Colors,
}

#[cfg(target_arch = "x86_64")]
impl pulp::NullaryFnOnce for LitByAvx2<'_> {
    type Output = Result<OverlayLayer, OpticsError>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.pattern.lit_by(self.avx2, self.layer, self.colors)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "at most MAX_SIDE_PX")]
fn side(px: usize) -> u32 {
    px as u32
}

/// Writes the runs that have anything in them.
fn write_chunks<const L: usize, const B: usize>(
    out: &mut Vec<u8>,
    chunks: &LaneRuns<L>,
    blocks: impl Fn((usize, usize), &LaneRun<L>) -> [Block; B],
) {
    let runs = chunks
        .iter()
        .map(|(x, y, run)| ((x, y), blocks((x, y), run)))
        .collect::<Vec<_>>();
    write_runs(out, chunks.size().0, &runs);
}

/// Writes the codes of a mask in the same way.
fn write_mask(out: &mut Vec<u8>, mask: &GrayImage) {
    let (width, height) = (mask.width() as usize, mask.height() as usize);
    let mut runs = Vec::new();
    for (y, row) in mask.as_raw().chunks(width.max(1)).enumerate().take(height) {
        for (across, codes) in row.chunks(CHUNK).enumerate() {
            let mut block = [0; CHUNK];
            for (to, code) in block.iter_mut().zip(codes) {
                *to = i32::from(*code);
            }
            if block.iter().any(|code| *code > 0) {
                runs.push(((across * CHUNK, y), [block]));
            }
        }
    }
    write_runs(out, width, &runs);
}
