//! What ffmpeg's names of pixel formats say.

/// Bits per channel, if they are more than 8, of a format such as `yuv420p10le` or `rgba64be`.
///
/// Formats of 8 bits and fewer, and names that are not known, give 8.
pub(super) fn bits_per_channel(format: &str) -> u32 {
    let name = format
        .strip_suffix("le")
        .or_else(|| format.strip_suffix("be"))
        .unwrap_or(format);
    // What is stored in one word for all channels, or as a fraction.
    let bits = match name {
        "rgb48" | "bgr48" | "rgba64" | "bgra64" | "ayuv64" | "ya16" | "y216" | "xv48" => 16,
        "xyz12" | "xv36" | "y212" => 12,
        "x2rgb10" | "x2bgr10" | "xv30" | "v30x" | "y210" => 10,
        "rgb96" | "rgba128" => 32,
        _ if name.ends_with("f32") => 32,
        _ if name.ends_with("f16") => 16,
        _ if name.starts_with("bayer_") && name.ends_with("16") => 16,
        _ => {
            // `gray12`, or what follows the last `p` (for planes), as in `gbrap14` and `p010`.
            let digits = name.strip_prefix("gray").or_else(|| {
                let (_, digits) = name.rsplit_once('p')?;
                Some(digits)
            });
            digits
                .and_then(|digits| digits.parse::<u32>().ok())
                .map_or(8, |bits| bits % 100)
        }
    };
    bits.max(8)
}

/// Whether a format such as `yuva420p` or `bgra` stores how opaque a pixel is.
pub(super) fn has_alpha(format: &str) -> bool {
    let starts = [
        "yuva", "rgba", "bgra", "argb", "abgr", "gbrap", "ya8", "ya16", "yaf", "ayuv", "vuya",
        "uyva",
    ];
    starts.iter().any(|start| format.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_bits_and_alpha() {
        for (format, bits, alpha) in [
            ("yuv420p", 8, false),
            ("yuvj420p", 8, false),
            ("yuv420p10le", 10, false),
            ("yuva444p12be", 12, true),
            ("nv12", 8, false),
            ("nv24", 8, false),
            ("p010le", 10, false),
            ("p216le", 16, false),
            ("gbrp", 8, false),
            ("gbrap", 8, true),
            ("gbrap14le", 14, true),
            ("gbrpf32le", 32, false),
            ("gray", 8, false),
            ("gray16le", 16, false),
            ("gray10le", 10, false),
            ("rgb24", 8, false),
            ("rgb48be", 16, false),
            ("rgba64le", 16, true),
            ("bgra", 8, true),
            ("bgr0", 8, false),
            ("rgb565le", 8, false),
            ("pal8", 8, false),
            ("uyyvyy411", 8, false),
            ("x2rgb10le", 10, false),
            ("", 8, false),
        ] {
            assert_eq!(bits_per_channel(format), bits, "{format}: bits");
            assert_eq!(has_alpha(format), alpha, "{format}: alpha");
        }
    }
}
