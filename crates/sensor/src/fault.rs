//! The faults behind the lens, in the order in which light meets them.

use crate::{Exposure, Filters, Frames, Isp, Lamps, Lines, Link, Noise, Pixels, RawRows, Spots};

/// A fault behind the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Too much light, or too little.
    Exposure(Exposure),
    /// Lamps that pulse.
    Lamps(Lamps),
    /// Dust on the sensor's cover.
    Spots(Spots),
    /// Color filters that are lost.
    Filters(Filters),
    /// Noise.
    Noise(Noise),
    /// Defective pixels.
    Pixels(Pixels),
    /// Defective rows and columns.
    Lines(Lines),
    /// Rows without interpolated colors.
    RawRows(RawRows),
    /// Stages of the image processor that are left out.
    Isp(Isp),
    /// What happens on the way to the computer.
    Link(Link),
    /// Frames that do not arrive.
    Frames(Frames),
}

/// What a fault changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Acts {
    /// Codes alone, or nothing.
    OnCodes,
    /// Light by a factor for each row.
    ByRows,
    /// Light of a few pixels.
    OnPixels,
    /// Light in any other way.
    OnLight,
}

impl Fault {
    /// What it changes of a frame.
    pub(crate) fn acts(&self) -> Acts {
        match self {
            _ if self.is_nothing() => Acts::OnCodes,
            Self::Link(_) | Self::Frames(_) => Acts::OnCodes,
            Self::Isp(isp) if isp.acts_on_no_light() => Acts::OnCodes,
            // A darker frame lacks noise, too.
            Self::Exposure(exposure) if exposure.ev > 0.0 => Acts::ByRows,
            Self::Lamps(_) => Acts::ByRows,
            Self::Pixels(_) | Self::Lines(_) => Acts::OnPixels,
            _ => Acts::OnLight,
        }
    }
}

macro_rules! each {
    ($($kind:ident),*) => {
        impl Fault {
            /// Whether it changes nothing, whatever the image.
            #[must_use]
            pub fn is_nothing(&self) -> bool {
                match self {
                    $(Self::$kind(fault) => fault.is_nothing(),)*
                }
            }
        }
        $(
            impl From<$kind> for Fault {
                fn from(fault: $kind) -> Self {
                    Self::$kind(fault)
                }
            }

            impl<'a> TryFrom<&'a Fault> for &'a $kind {
                type Error = ();

                fn try_from(fault: &'a Fault) -> Result<Self, ()> {
                    match fault {
                        Fault::$kind(fault) => Ok(fault),
                        _ => Err(()),
                    }
                }
            }
        )*
    };
}

each!(
    Exposure, Lamps, Spots, Filters, Noise, Pixels, Lines, RawRows, Isp, Link, Frames
);
