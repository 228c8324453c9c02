//! A message of a camera: what stands in it, its pixels, and the same with others.

use std::ops::Range;

use image::GrayImage;
use starbreak::optics::{Channels, FrameMut};
use starbreak_dataset::{
    Encoding, ImageFile, ImageFormat, ImageLimits, JpegQuality, decode_image, encode_image_as,
};

use super::cdr::{Order, Walk, Written, length_of};
use crate::bag_error::MessageFault;
use crate::clip::pixels::RowLayout;

/// What may lie behind the last field: padding to a multiple of 4.
const MAX_PADDING: usize = 3;

/// What a topic of a camera holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraKind {
    /// `sensor_msgs/msg/Image`.
    Raw,
    /// `sensor_msgs/msg/CompressedImage`.
    Compressed,
}

/// What stands in a message of a camera, and where. Nothing of it is written again but `data`.
#[derive(Debug)]
pub struct CameraMessage {
    order: Order,
    /// Seconds and nanoseconds of the header.
    stamp: (i32, u32),
    frame_id: Range<usize>,
    picture: Picture,
    /// Where the bytes of `data` lie.
    data: Range<usize>,
}

/// How a message holds its picture.
#[derive(Debug, Clone)]
enum Picture {
    Raw(RowLayout),
    Compressed { format: String },
}

/// Encodings of raw images that are damaged, of 8 bits per channel.
const ENCODINGS: [(&str, Channels); 5] = [
    ("rgb8", Channels::Rgb),
    ("bgr8", Channels::Bgr),
    ("rgba8", Channels::Rgba),
    ("bgra8", Channels::Bgra),
    (MASK_ENCODING, Channels::Gray),
];

/// The encoding of masks.
const MASK_ENCODING: &str = "mono8";

/// The name and the channels of an encoding; of the others the reason why not.
fn encoding_of(encoding: &str) -> Result<(&'static str, Channels), MessageFault> {
    let known = ENCODINGS.into_iter().find(|(name, _)| *name == encoding);
    known.ok_or_else(|| MessageFault::Encoding {
        encoding: encoding.to_owned(),
        reason: match no_picture(encoding) {
            Some(reason) => reason,
            None if encoding.starts_with("8U") => "it does not say which channel is which color",
            None => "not known",
        },
    })
}

/// Why the pixels of an encoding are no picture of 8 bits, where it says that they are none.
fn no_picture(encoding: &str) -> Option<&'static str> {
    if encoding.starts_with("bayer_") {
        Some(
            "a mosaic has one color per pixel, and glass comes before it; demosaic it first, for example with image_proc",
        )
    } else if encoding.starts_with("yuv") || encoding.starts_with("nv") {
        Some("luma and chroma; convert it first, for example with image_proc")
    } else if ["16", "32", "64"].iter().any(|it| encoding.contains(it)) {
        Some("more than 8 bits per channel, as depth has")
    } else {
        None
    }
}

/// Refuses a compressed image whose `format` says that its pixels are no picture: `image_transport` writes
/// `ENCODING; jpeg compressed TARGET`, where `TARGET` is what colors were converted to, and nothing for pixels that
/// were compressed as they are.
fn check_format(format: &str) -> Result<(), MessageFault> {
    let (encoding, packed) = format.split_once(';').unwrap_or((format, ""));
    let (encoding, target) = match packed.split_once("compressed") {
        Some((_, target)) if !target.trim().is_empty() => (encoding.trim(), target.trim()),
        _ => (encoding.trim(), encoding.trim()),
    };
    match no_picture(target) {
        Some(reason) => Err(MessageFault::Encoding {
            encoding: encoding.to_owned(),
            reason,
        }),
        None => Ok(()),
    }
}

impl CameraMessage {
    /// Finds everything in a message.
    ///
    /// # Errors
    /// [`MessageFault`] for an encapsulation other than plain CDR, a message that is cut or claims more than it has,
    /// an encoding that is not damaged, and rows that do not fit `data`.
    pub fn read(kind: CameraKind, message: &[u8]) -> Result<Self, MessageFault> {
        let mut walk = Walk::of(message)?;
        let seconds = walk.u32("header.stamp.sec")?.cast_signed();
        let nanoseconds = walk.u32("header.stamp.nanosec")?;
        let frame_id = walk.text("header.frame_id")?;
        let (picture, data) = match kind {
            CameraKind::Raw => Self::raw(&mut walk, message)?,
            CameraKind::Compressed => {
                let format = text_of(message, walk.text("format")?);
                let data = walk.sequence("data")?;
                if format.contains("compressedDepth") {
                    let reason = "depth is no light";
                    return Err(MessageFault::Format { format, reason });
                }
                check_format(&format)?;
                (Picture::Compressed { format }, data)
            }
        };
        if walk.n_left() > MAX_PADDING {
            return Err(MessageFault::Behind {
                n_bytes: walk.n_left(),
            });
        }
        Ok(Self {
            order: walk.order(),
            stamp: (seconds, nanoseconds),
            frame_id,
            picture,
            data,
        })
    }

    fn raw(walk: &mut Walk<'_>, message: &[u8]) -> Result<(Picture, Range<usize>), MessageFault> {
        let height = walk.u32("height")?;
        let width = walk.u32("width")?;
        let encoding = text_of(message, walk.text("encoding")?);
        // Of 8 bits there is one order of bytes.
        let _ = walk.u8("is_bigendian")?;
        let step = walk.u32("step")?;
        let data = walk.sequence("data")?;
        let (encoding, channels) = encoding_of(&encoding)?;
        let limits = ImageLimits::default();
        let sides = 1..=limits.max_side_px;
        let n_pixels = u64::from(width) * u64::from(height);
        if !(sides.contains(&width) && sides.contains(&height) && n_pixels <= limits.max_pixels) {
            return Err(MessageFault::Size { width, height });
        }
        let n_row = u64::from(width) * channels.n_samples() as u64;
        if u64::from(step) < n_row {
            return Err(MessageFault::Step {
                step,
                width,
                encoding,
                n_row,
            });
        }
        let least = u64::from(height - 1) * u64::from(step) + n_row;
        let most = u64::from(height) * u64::from(step);
        if !(least..=most).contains(&(data.len() as u64)) {
            return Err(MessageFault::Data {
                n_bytes: data.len(),
                height,
                step,
                least,
                most,
            });
        }
        let layout = RowLayout {
            start: data.start,
            step: usize::try_from(step).unwrap_or(usize::MAX),
            size: (width, height),
            channels,
        };
        Ok((Picture::Raw(layout), data))
    }

    /// Time of the header, ns.
    #[must_use]
    pub fn stamp_ns(&self) -> i64 {
        i64::from(self.stamp.0) * 1_000_000_000 + i64::from(self.stamp.1)
    }

    /// Whether the message that this was read from holds JPEG, by its first bytes.
    #[must_use]
    pub fn is_jpeg(&self, message: &[u8]) -> bool {
        let data = message.get(self.data.clone()).unwrap_or_default();
        matches!(self.picture, Picture::Compressed { .. }) && data.starts_with(&[0xff, 0xd8])
    }

    /// Where the pixels of a raw image lie in the message that this was read from.
    pub(super) fn layout(&self) -> Option<RowLayout> {
        match self.picture {
            Picture::Raw(layout) => Some(layout),
            Picture::Compressed { .. } => None,
        }
    }

    /// The pixels of a raw image, where they lie in the message that this was read from; none of a compressed one.
    #[must_use]
    pub fn frame<'a>(&self, message: &'a mut [u8]) -> Option<FrameMut<'a>> {
        self.layout()?.frame(message).ok()
    }

    /// The file of a compressed image in the message that this was read from; none of a raw one.
    ///
    /// # Errors
    /// [`MessageFault::Format`] and [`MessageFault::Image`] for a compressed image that is not JPEG or PNG, has
    /// more than 8 bits per channel, or is broken.
    pub fn file(
        &self,
        message: &[u8],
        limits: &ImageLimits,
    ) -> Result<Option<ImageFile>, MessageFault> {
        let Picture::Compressed { format } = &self.picture else {
            return Ok(None);
        };
        let data = message.get(self.data.clone()).unwrap_or_default();
        let file = decode_image("data", data, limits)?;
        if !matches!(file.format, ImageFormat::Jpeg | ImageFormat::Png) {
            return Err(MessageFault::Format {
                format: format.clone(),
                reason: "the data are of another one",
            });
        }
        let color = file.pixels.color();
        if color.bytes_per_pixel() > color.channel_count() {
            return Err(MessageFault::Format {
                format: format.clone(),
                reason: "the data have more than 8 bits per channel, as depth has",
            });
        }
        Ok(Some(file))
    }

    /// The message of a compressed image with the file in its place, whose pixels may be others of the same size and
    /// colors: all before `data` as it was. JPEG is written with the quality, PNG without loss.
    ///
    /// # Errors
    /// [`MessageFault::Image`] for pixels that the format does not hold.
    pub fn with_file(
        &self,
        message: &[u8],
        file: &ImageFile,
        quality: JpegQuality,
    ) -> Result<Vec<u8>, MessageFault> {
        let encoding = match file.format {
            ImageFormat::Jpeg => Encoding::Jpeg { quality },
            _ => Encoding::Png,
        };
        self.spliced(message, &encode_image_as(file, &encoding)?)
    }

    /// The message with other bytes of `data`. Padding behind it stays padding to a multiple of 4, which the header
    /// tells if it did before.
    fn spliced(&self, message: &[u8], data: &[u8]) -> Result<Vec<u8>, MessageFault> {
        let Range { start, end } = self.data;
        let head = message.get(..start - 4).unwrap_or_default();
        let n_padding = message.len() - end;
        let mut spliced = Vec::with_capacity(head.len() + data.len() + 8);
        spliced.extend_from_slice(head);
        spliced.extend_from_slice(&self.order.bytes(length_of(data)?));
        spliced.extend_from_slice(data);
        if n_padding > 0 {
            let n_bytes = spliced.len();
            spliced.resize(n_bytes.next_multiple_of(4), 0);
            let is_told = message
                .get(3)
                .is_some_and(|told| usize::from(told & 3) == n_padding);
            if let (true, Some(told)) = (is_told, spliced.get_mut(3)) {
                let n_new = u8::try_from(n_bytes.next_multiple_of(4) - n_bytes).unwrap_or(0);
                *told = (*told & !3) | n_new;
            }
        }
        Ok(spliced)
    }

    /// A mask as a message of its own: `sensor_msgs/msg/Image` in mono8, with the stamp and the frame of this one.
    ///
    /// # Errors
    /// [`MessageFault::TooLong`] for a mask beyond 4 GiB.
    pub fn mask(&self, message: &[u8], mask: &GrayImage) -> Result<Vec<u8>, MessageFault> {
        let mut written = Written::new();
        written.u32(self.stamp.0.cast_unsigned());
        written.u32(self.stamp.1);
        written.text(message.get(self.frame_id.clone()).unwrap_or_default())?;
        written.u32(mask.height());
        written.u32(mask.width());
        written.text(MASK_ENCODING.as_bytes())?;
        written.u8(0);
        written.u32(mask.width());
        written.sequence(mask.as_raw())?;
        Ok(written.into_bytes())
    }
}

/// A line of text as a message of its own: `std_msgs/msg/String`.
pub(super) fn text_message(text: &str) -> Result<Vec<u8>, MessageFault> {
    let mut written = Written::new();
    written.text(text.as_bytes())?;
    Ok(written.into_bytes())
}

fn text_of(message: &[u8], range: Range<usize>) -> String {
    String::from_utf8_lossy(message.get(range).unwrap_or_default()).into_owned()
}
