//! The formats of images and of datasets, by name.

use std::fmt;

/// The image formats which are read; PNG and JPEG are written, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// Portable Network Graphics. Of an animated PNG only the default image is read.
    Png,
    /// JPEG, baseline or progressive, 8 bits per channel.
    Jpeg,
    /// WebP, with or without loss. Of an animation only the first image is read.
    WebP,
    /// Windows bitmap.
    Bmp,
}

impl ImageFormat {
    /// The usual extension of file names, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
            Self::WebP => "webp",
            Self::Bmp => "bmp",
        }
    }
}

impl fmt::Display for ImageFormat {
    /// Writes its name in capitals, `WebP` as here.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Bmp => "BMP",
        })
    }
}

/// The layouts of datasets which are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SourceFormat {
    /// KITTI object detection: `image_2`, `label_2`, `calib`, bare or below `training`, `testing`.
    Kitti,
    /// MS-COCO: `annotations/instances_*.json` and the images they name.
    Coco,
    /// BDD100K `det_20`: JSON lists of frames in Scalabel form and the images they name.
    Bdd,
    /// YOLO: `data.yaml`, images, and a text of labels per image.
    Yolo,
    /// All images below a folder, without labels.
    Folder,
    /// The images named in a text file, without labels.
    List,
}

impl SourceFormat {
    /// All formats, in the order in which messages name them.
    pub const ALL: [Self; 6] = [
        Self::Kitti,
        Self::Coco,
        Self::Bdd,
        Self::Yolo,
        Self::Folder,
        Self::List,
    ];

    /// The word before the colon: `kitti`, `coco`, `bdd`, `yolo`, `folder` or `list`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kitti => "kitti",
            Self::Coco => "coco",
            Self::Bdd => "bdd",
            Self::Yolo => "yolo",
            Self::Folder => "folder",
            Self::List => "list",
        }
    }
}

impl fmt::Display for SourceFormat {
    /// Writes [`SourceFormat::name`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
