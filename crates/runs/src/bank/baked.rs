//! What the optics baked of a pattern, and its record.

use image::GrayImage;
use starbreak::{OpticsSettings, PaneLayer, Settings};
use starbreak_dataset::encode_mask;
use starbreak_glass::CrackNetwork;
use starbreak_optics::physical::PackedPattern;
use starbreak_optics::{Coverage, OpticsError};
use starbreak_seed::Seed;

use super::PatternFacts;
use crate::Error;

/// What the record of one pattern at one frame size holds.
pub(super) struct BakedRecord {
    pub(super) facts: PatternFacts,
    pub(super) crack_mask_png: Vec<u8>,
    packed: Vec<u8>,
}

/// Bakes a network for a frame; its crack mask comes along.
pub(super) fn bake_record(
    settings: &Settings,
    network: &CrackNetwork,
    size: (u32, u32),
    seed: Seed,
) -> Result<(BakedRecord, GrayImage), Error> {
    let layer = PaneLayer::of_network(settings, (network, f64::INFINITY), size, seed)?;
    let packed = match &layer {
        PaneLayer::Paper(drawn) => drawn.to_packed(),
        PaneLayer::Baked(pattern) => pattern.to_packed(),
        PaneLayer::Packed(_) | PaneLayer::Photo { .. } => {
            return Err(starbreak::Error::OtherOptics.into());
        }
    };
    let mask = match layer {
        // As it comes out of the bank.
        PaneLayer::Paper(_) => Coverage::from_packed(&packed)?.to_mask(),
        layer => layer.crack_mask()?,
    };
    let record = BakedRecord {
        facts: PatternFacts::of(network, seed),
        crack_mask_png: encode_mask(&mask)?,
        packed,
    };
    Ok((record, mask))
}

impl BakedRecord {
    /// Facts as JSON, mask and pattern, each but the last after its length.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let facts = serde_json::to_vec(&self.facts).unwrap_or_default();
        let mut out =
            Vec::with_capacity(facts.len() + self.crack_mask_png.len() + self.packed.len() + 8);
        for part in [&facts, &self.crack_mask_png] {
            let n = u32::try_from(part.len()).unwrap_or(u32::MAX);
            out.extend_from_slice(&n.to_le_bytes());
            out.extend_from_slice(part);
        }
        out.extend_from_slice(&self.packed);
        out
    }

    /// What [`BakedRecord::to_bytes`] wrote, or what is wrong with it.
    pub(super) fn of_bytes(mut bytes: Vec<u8>) -> Result<Self, String> {
        let (facts, rest) = part_of(&bytes).ok_or("it ends in its facts")?;
        let (mask, packed) = part_of(rest).ok_or("it ends in its mask")?;
        Ok(Self {
            facts: serde_json::from_slice(facts).map_err(|cause| cause.to_string())?,
            crack_mask_png: mask.to_vec(),
            packed: {
                let from = bytes.len() - packed.len();
                bytes.drain(..from);
                bytes
            },
        })
    }

    /// Its parts: facts, crack mask, and what the optics of these settings want.
    pub(super) fn into_parts(
        self,
        settings: &Settings,
    ) -> Result<(PatternFacts, Vec<u8>, PaneLayer), OpticsError> {
        let layer = match settings.optics {
            OpticsSettings::Paper(_) => PaneLayer::Paper(Coverage::from_packed(&self.packed)?),
            OpticsSettings::Physical(_) => PaneLayer::Packed(PackedPattern::new(self.packed)?),
        };
        Ok((self.facts, self.crack_mask_png, layer))
    }
}

/// A part behind its length, and what follows it.
fn part_of(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (n, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*n) as usize)
}
