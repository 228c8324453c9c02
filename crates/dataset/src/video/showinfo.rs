//! What ffmpeg's filter `showinfo` says of each frame.

use super::Fraction;

/// One frame, as ffmpeg describes it before it becomes RGB.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct FrameInfo {
    /// When it is shown, ticks; `None` where the clip does not say.
    pub(super) ticks: Option<i64>,
    pub(super) width_px: u32,
    pub(super) height_px: u32,
    /// Width of a pixel over its height; `None` where the clip does not say.
    pub(super) pixel_aspect: Option<Fraction>,
    /// Seconds per tick.
    pub(super) time_base: Option<Fraction>,
    /// Frames per second; `None` where the clip does not say.
    pub(super) rate: Option<Fraction>,
    /// ffmpeg's name of how its pixels are stored.
    pub(super) pixel_format: String,
    pub(super) color: Color,
}

/// How a clip stores color, by ffmpeg's names; empty where it does not say.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Color {
    /// `tv` or `pc`.
    pub(super) range: String,
    /// The matrix between RGB and YUV.
    pub(super) space: String,
    pub(super) primaries: String,
    pub(super) transfer: String,
}

impl FrameInfo {
    /// Reads one line of the filter. A frame has two, with others about side data between them; it is
    /// passed on after the second. `pending` keeps what is known so far.
    pub(super) fn read_line(pending: &mut Option<Self>, line: &str, seen: &mut impl FnMut(Self)) {
        let value = |key| value_of(line, key);
        if let Some(base) = line.split_once("config in time_base: ") {
            let (base, rate) = base.1.split_once(", frame_rate: ").unwrap_or((base.1, ""));
            *pending = Some(Self {
                time_base: fraction(base, '/'),
                rate: fraction(rate, '/'),
                ..Self::default()
            });
        } else if let (Some(ticks), Some((width, height))) = (
            value("pts:"),
            value("s:").and_then(|size| size.split_once('x')),
        ) {
            let info = pending.get_or_insert_default();
            info.ticks = ticks.parse().ok();
            info.width_px = width.parse().unwrap_or(0);
            info.height_px = height.parse().unwrap_or(0);
            info.pixel_format = value("fmt:").unwrap_or_default().to_owned();
            info.pixel_aspect = value("sar:").and_then(|aspect| fraction(aspect, '/'));
        } else if let Some(range) = value("color_range:")
            && let Some(info) = pending
        {
            let known = |name: &str| match name {
                "unknown" | "unspecified" | "reserved" => String::new(),
                name => name.to_owned(),
            };
            info.color = Color {
                range: known(range),
                space: known(value("color_space:").unwrap_or_default()),
                primaries: known(value("color_primaries:").unwrap_or_default()),
                transfer: known(value("color_trc:").unwrap_or_default()),
            };
            seen(info.clone());
        }
    }
}

/// The word after a key that stands alone, with or without spaces between them.
fn value_of<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let mut from = 0;
    while let Some(at) = line.get(from..)?.find(key) {
        let start = from + at;
        from = start + key.len();
        if start == 0 || line.get(..start)?.ends_with(' ') {
            return line.get(from..)?.split_whitespace().next();
        }
    }
    None
}

fn fraction(text: &str, between: char) -> Option<Fraction> {
    let (above, below) = text.trim().split_once(between)?;
    Fraction::new(above.parse().ok()?, below.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_read_from_its_lines() {
        let lines = "\
[Parsed_showinfo_0 @ 0x7f] [info] config in time_base: 1/30000, frame_rate: 30000/1001
[Parsed_showinfo_0 @ 0x7f] [info] config out time_base: 0/0, frame_rate: 0/0
[Parsed_showinfo_0 @ 0x7f] [info] n:   0 pts:      0 pts_time:0       duration:   1001 duration_time:0.0333667 fmt:yuv444p cl:left sar:4/3 s:321x241 i:P iskey:1 type:I
[Parsed_showinfo_0 @ 0x7f] [info]   side data - H.26[45] User Data Unregistered SEI message
[Parsed_showinfo_0 @ 0x7f] [info] color_range:tv color_space:bt709 color_primaries:unknown color_trc:bt709
[Parsed_showinfo_0 @ 0x7f] [info] n:   1 pts: NOPTS pts_time:NOPTS   fmt:yuv444p sar:0/1 s:321x241 i:P
[Parsed_showinfo_0 @ 0x7f] [info] color_range:unknown color_space:unknown color_primaries:unknown color_trc:unknown";
        let (mut pending, mut found) = (None, Vec::new());
        for line in lines.lines() {
            FrameInfo::read_line(&mut pending, line, &mut |info| found.push(info));
        }
        let first = FrameInfo {
            ticks: Some(0),
            width_px: 321,
            height_px: 241,
            pixel_aspect: Fraction::new(4, 3),
            time_base: Fraction::new(1, 30_000),
            rate: Fraction::new(30_000, 1001),
            pixel_format: "yuv444p".to_owned(),
            color: Color {
                range: "tv".to_owned(),
                space: "bt709".to_owned(),
                primaries: String::new(),
                transfer: "bt709".to_owned(),
            },
        };
        let second = FrameInfo {
            ticks: None,
            pixel_aspect: None,
            color: Color::default(),
            ..first.clone()
        };
        assert_eq!(found, [first, second], "two frames");
    }
}
