mod bank;
mod video;
mod words;

use std::io;
use std::path::PathBuf;

use crate::formats::{ImageFormat, SourceFormat};
pub use bank::BankFault;
pub use video::VideoError;
pub(crate) use words::one_line;
use words::{bank_way_out, io_fact, io_way_out};

/// What went wrong with a file or a codec, as one line: the file, the fact, the way out.
///
/// File names are printed quoted, with control characters, newlines and invisible characters
/// escaped, so that a message is always one line and shows what is really there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The file system refused to read the file.
    #[error("cannot read {path:?}: {}; {}", io_fact(.source), io_way_out(.source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The path to be read is a folder, a pipe, a socket or a device.
    #[error("cannot read {path:?}: it is {what}; give the path of a file")]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// What it is, with its article.
        what: &'static str,
    },
    /// The file has no bytes.
    #[error("{name:?} is empty (0 bytes); copy or download it again")]
    EmptyFile {
        /// The file.
        name: String,
    },
    /// The file has more bytes than its limit, [`crate::ImageLimits::max_file_bytes`] for an image.
    #[error("{name:?} is longer than the limit of {max_bytes} bytes; make it smaller")]
    FileTooLong {
        /// The file.
        name: String,
        /// The limit, in bytes.
        max_bytes: u64,
    },
    /// An array whose sides do not multiply to the number of its values.
    #[error("an array of shape {shape:?} does not hold {n_values} values")]
    ArrayShape {
        /// The sides.
        shape: Vec<usize>,
        /// How many values there are.
        n_values: usize,
    },
    /// A file that is not an array of floats.
    #[error(
        "{name:?} is not a NumPy file of floats: {reason}; write it with numpy.save of numpy.ascontiguousarray(x, \"<f4\")"
    )]
    BadArray {
        /// The file.
        name: String,
        /// Why not.
        reason: String,
    },
    /// A JSON file that is none, or that has another form than lists of records.
    #[error(
        "{path:?} is not the JSON it should be from byte {at_byte} on: {}; write or copy it again", one_line(.reason)
    )]
    JsonText {
        /// The file.
        path: PathBuf,
        /// Place of the first byte that is wrong, from 0.
        at_byte: u64,
        /// What is wrong.
        reason: String,
    },
    /// A text file that is not UTF-8.
    #[error("{name:?} is not UTF-8 text from byte {at} on; save it as UTF-8")]
    NotText {
        /// The file.
        name: String,
        /// Place of the first byte that is wrong, from 0.
        at: usize,
    },
    /// The first bytes are those of no format that is read.
    #[error(
        "{name:?} is not PNG, JPEG, WebP or BMP, it looks like {looks_like}; convert it to PNG"
    )]
    UnknownFormat {
        /// The file.
        name: String,
        /// A guess from the first bytes, with its article.
        looks_like: &'static str,
    },
    /// The header announces more pixels than [`crate::ImageLimits`] admit.
    #[error(
        "{name:?} is {width_px} x {height_px} px; the limit is {max_side_px} px per side and \
         {max_pixels} px in all, so scale the image down"
    )]
    ImageTooLarge {
        /// The file.
        name: String,
        /// Width in the header, in pixels.
        width_px: u32,
        /// Height in the header, in pixels.
        height_px: u32,
        /// The limit of each side, in pixels.
        max_side_px: u32,
        /// The limit of width times height, in pixels.
        max_pixels: u64,
    },
    /// The file ends before the image does.
    #[error(
        "{name:?} is cut short: the {format} data end after {n_bytes} bytes, before the image does; copy or download it again"
    )]
    Truncated {
        /// The file.
        name: String,
        /// Its format.
        format: ImageFormat,
        /// Length of the file, in bytes.
        n_bytes: usize,
    },
    /// The content breaks the rules of its format.
    #[error("{name:?} is not a valid {format} file: {reason}; copy or download it again")]
    Corrupt {
        /// The file.
        name: String,
        /// Its format.
        format: ImageFormat,
        /// What the decoder says.
        reason: String,
    },
    /// The file is valid, but uses a part of its format that is not supported.
    #[error(
        "{name:?} uses a part of {format} that is not supported: {reason}; convert it to 8-bit PNG"
    )]
    UnsupportedFeature {
        /// The file.
        name: String,
        /// Its format.
        format: ImageFormat,
        /// What the decoder says.
        reason: String,
    },
    /// A JPEG quality outside 1 to 100.
    #[error("jpeg quality = {quality}; expected 1 to 100")]
    JpegQuality {
        /// The value given.
        quality: u8,
    },
    /// The pixel mode has no place in the output format.
    #[error("{format} cannot store {mode} pixels; {way_out}")]
    UnsupportedMode {
        /// The output format.
        format: ImageFormat,
        /// The pixel mode, such as `Rgba8`.
        mode: &'static str,
        /// What to do instead.
        way_out: &'static str,
    },
    /// The image has no pixels or too many for the format.
    #[error(
        "an image of {width_px} x {height_px} px cannot be stored as {format}; expected 1 to {max_side_px} px per side"
    )]
    ImageSize {
        /// The output format.
        format: ImageFormat,
        /// Width in pixels.
        width_px: u32,
        /// Height in pixels.
        height_px: u32,
        /// The largest side of the format, in pixels.
        max_side_px: u32,
    },
    /// The encoder refused, for instance a color profile that is too long.
    #[error("cannot encode the image as {format}: {reason}; try without a color profile")]
    Encode {
        /// The output format.
        format: ImageFormat,
        /// What the encoder says.
        reason: String,
    },
    /// An animation without frames.
    #[error("the animation has no frames; expected at least 1")]
    NoFrames,
    /// A frame of another size than the first.
    #[error(
        "animation frame {frame_idx} is {width_px} x {height_px} px, but frame 0 is \
         {expected_width_px} x {expected_height_px} px; give all frames the same size"
    )]
    FrameSize {
        /// Index of the frame, from 0.
        frame_idx: usize,
        /// Its width in pixels.
        width_px: u32,
        /// Its height in pixels.
        height_px: u32,
        /// Width of frame 0 in pixels.
        expected_width_px: u32,
        /// Height of frame 0 in pixels.
        expected_height_px: u32,
    },
    /// The file system refused to write the file or to create its folder.
    #[error("cannot write {path:?}: {}; {}", io_fact(.source), io_way_out(.source))]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The destination is there and is not an ordinary file, or its path names a folder.
    #[error("cannot write {path:?}: it is {what}; give the path of a file")]
    DestinationNotAFile {
        /// The destination.
        path: PathBuf,
        /// What it is, with its article.
        what: &'static str,
    },
    /// A file is there that is not known to be of an earlier run.
    #[error("{path:?} is there already; choose another name or folder, or give --replace")]
    Taken {
        /// The file.
        path: PathBuf,
    },
    /// A file of an earlier run that was changed since.
    #[error(
        "{path:?} is no longer as an earlier run wrote it; move it away, or give --replace to write it anew"
    )]
    Altered {
        /// The file.
        path: PathBuf,
    },
    /// An output would take the place of a file that is read.
    #[error(
        "the output {output:?} would replace the input {input:?}; choose another name or folder"
    )]
    OutputIsInput {
        /// The input.
        input: PathBuf,
        /// The output.
        output: PathBuf,
    },
    /// The same destination was staged before.
    #[error("two outputs of one sample have the same path {path:?}; give them different names")]
    DuplicateOutput {
        /// The destination.
        path: PathBuf,
    },
    /// A batch failed while its files were renamed into place.
    #[error(
        "cannot put {path:?} in place: {}; {} existing files were already replaced, new files were removed; {}",
        io_fact(.source), .replaced.len(), io_way_out(.source)
    )]
    Commit {
        /// The destination that failed.
        path: PathBuf,
        /// Destinations which existed before and now hold the new content.
        replaced: Vec<PathBuf>,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A folder holds a set that was made from something else.
    #[error(
        "{path:?} holds another set: its {key} is {found}, here it is {wanted}; choose another output folder or the \
         same settings"
    )]
    OtherSet {
        /// The folder.
        path: PathBuf,
        /// What differs.
        key: String,
        /// Its value there, as JSON.
        found: String,
        /// Its value here.
        wanted: String,
    },
    /// Another process works on the folder.
    #[error("{path:?} is in use by another run; wait for it or choose another output folder")]
    FolderInUse {
        /// The folder.
        path: PathBuf,
    },
    /// A folder that is no generated set.
    #[error("{path:?} is not a generated set: {reason}")]
    NotASet {
        /// The folder.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Samples that are neither made nor failed when the lists are written.
    #[error(
        "of {n_taken} images of {path:?}, {n_items} are there as they were made and {n_failed} failed: others came or \
         were altered during the run; run the same command again"
    )]
    LostItems {
        /// The set.
        path: PathBuf,
        /// Samples that are there.
        n_items: u64,
        /// Samples that failed.
        n_failed: u64,
        /// Samples that were taken.
        n_taken: u64,
    },
    /// A record of ours that cannot be understood.
    #[error("{path:?} is damaged: {reason}; generate the set again")]
    Record {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A set of another version.
    #[error(
        "{path:?} is of another version: its schema is {found}, where this one reads {wanted:?}; generate the set \
         into another folder"
    )]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Its schema, as JSON.
        found: String,
        /// The schema of this version.
        wanted: &'static str,
    },
    /// A name that would lead out of its folder.
    #[error("{name:?} is no path inside the set; expected a relative one without `..`")]
    UnsafeName {
        /// The name.
        name: String,
    },
    /// Shards that are no whole.
    #[error("the shards are no whole set: {reason}")]
    Shards {
        /// Why.
        reason: String,
    },
    /// Input and output are in each other.
    #[error(
        "the output {output:?} and the input {input:?} lie in each other; choose a folder beside it"
    )]
    OutputInInput {
        /// The input.
        input: PathBuf,
        /// The output.
        output: PathBuf,
    },
    /// A folder for other files lies in a generated set.
    #[error(
        "{path:?} is in the dataset {set:?} that `generate` has made, where other files would be foreign; choose \
         a folder beside it"
    )]
    InsideSet {
        /// The folder.
        path: PathBuf,
        /// The set.
        set: PathBuf,
    },
    /// A bank file that cannot be read or written.
    #[error("the bank {path:?} cannot be used: {fault}; {}", bank_way_out(.fault))]
    Bank {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: BankFault,
    },
    /// A clip could not be read or written.
    #[error(transparent)]
    Video(#[from] VideoError),
    /// A provenance record that is not a JSON object with a `schema`.
    #[error(
        "the provenance record is not valid: {reason}; expected a JSON object with a text field \"schema\""
    )]
    Provenance {
        /// What is wrong.
        reason: String,
    },
    /// A word that does not name a dataset, such as one without a format.
    #[error(
        "{text:?} {problem}; expected kitti:DIR, coco:DIR, bdd:DIR, yolo:DIR, folder:DIR or \
         list:FILE{suggestion}"
    )]
    SourceSpec {
        /// The word.
        text: String,
        /// What is wrong with it.
        problem: &'static str,
        /// The word that may be meant, as the end of the message; empty where there is no guess.
        suggestion: String,
    },
    /// The folder is not laid out as its format says.
    #[error("cannot read {path:?} as a {format} dataset: {}", one_line(.reason))]
    SourceLayout {
        /// The folder or file.
        path: PathBuf,
        /// The format.
        format: SourceFormat,
        /// What is wrong.
        reason: String,
    },
    /// An index file of a dataset that is broken as a whole.
    #[error("{path:?} is not a valid {format} index: {}", one_line(.reason))]
    SourceIndex {
        /// The file.
        path: PathBuf,
        /// The format of the dataset.
        format: SourceFormat,
        /// What is wrong, and where.
        reason: String,
    },
    /// A label of which a part cannot be moved with what its image shows.
    #[error(
        "{path:?}: {place}: {what} cannot be moved with what the image shows; leave it out of the labels, or take a \
         lens that moves nothing"
    )]
    Unmovable {
        /// The file.
        path: PathBuf,
        /// Which label.
        place: String,
        /// Which part of it, and why not.
        what: String,
    },
    /// The changed copy of an index or a label file cannot be written.
    #[error("cannot write the changed copy of {name:?}: {}; {}", io_fact(.source), io_way_out(.source))]
    SubsetWrite {
        /// Name of the file in its dataset.
        name: String,
        /// The error of the writer.
        source: io::Error,
    },
}

impl DatasetError {
    /// Whether it would meet every other output, too: the disk is full, read-only or not ours to
    /// write on.
    #[must_use]
    pub fn is_of_the_disk(&self) -> bool {
        let (Self::Write { source, .. }
        | Self::Commit { source, .. }
        | Self::SubsetWrite { source, .. }) = self
        else {
            return false;
        };
        matches!(
            source.kind(),
            io::ErrorKind::StorageFull
                | io::ErrorKind::QuotaExceeded
                | io::ErrorKind::ReadOnlyFilesystem
                | io::ErrorKind::PermissionDenied
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_is_one_line_whatever_the_name() {
        let name = "a\nb\r\u{1b}[31m\u{202e}\".png".to_owned();
        let message = DatasetError::EmptyFile { name: name.clone() }.to_string();
        assert!(!message.chars().any(char::is_control), "{message:?}");
        assert!(!message.contains('\u{202e}'), "{message:?}");
        assert!(message.contains(r"a\nb\r"), "{message:?}");

        let source = io::Error::other("two\nlines");
        let message = DatasetError::Read {
            path: name.into(),
            source,
        }
        .to_string();
        assert!(!message.chars().any(char::is_control), "{message:?}");
        assert!(message.contains(r"two\nlines"), "{message:?}");
    }
}
