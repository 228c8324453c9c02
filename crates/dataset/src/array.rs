use crate::DatasetError;

/// Bytes before the text of the header: magic, version, and how long that text is.
const PREFIX: usize = 10;

/// Numbers begin at a multiple of this, so that a file can be mapped into memory.
const ALIGNMENT: usize = 64;

/// A NumPy file (`.npy`, version 1.0) of little-endian 32-bit floats in C order: the last index of
/// the shape runs fastest. `numpy.load(name)` reads it, exact to the bit.
///
/// **Source**: the format's description in NumPy's documentation, `numpy.lib.format`.
///
/// # Errors
/// [`DatasetError::ArrayShape`] if the shape is not that of the values.
///
/// # Example
/// ```
/// let file = starbreak_dataset::encode_array(&[1, 2], &[0.5, 2.0])?;
/// assert_eq!(file[..6], *b"\x93NUMPY");
/// assert_eq!(file[file.len() - 4..], 2_f32.to_le_bytes());
/// # Ok::<(), starbreak_dataset::DatasetError>(())
/// ```
pub fn encode_array(shape: &[usize], values: &[f32]) -> Result<Vec<u8>, DatasetError> {
    encode("<f4", shape, values, |value| value.to_le_bytes())
}

/// The same of 64-bit floats.
///
/// # Errors
/// As [`encode_array`].
pub fn encode_array_f64(shape: &[usize], values: &[f64]) -> Result<Vec<u8>, DatasetError> {
    encode("<f8", shape, values, |value| value.to_le_bytes())
}

/// The file of values of one kind.
fn encode<T: Copy, const N: usize>(
    kind: &str,
    shape: &[usize],
    values: &[T],
    bytes_of: impl Fn(T) -> [u8; N],
) -> Result<Vec<u8>, DatasetError> {
    let wrong = || DatasetError::ArrayShape {
        shape: shape.to_vec(),
        n_values: values.len(),
    };
    if shape.iter().product::<usize>() != values.len() {
        return Err(wrong());
    }
    // A tuple of Python: one of one member ends in a comma.
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    let end = if sides.len() == 1 { "," } else { "" };
    let mut header = format!(
        "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}{end}), }}",
        sides.join(", ")
    );
    let unpadded = PREFIX + header.len() + 1;
    let padding = unpadded.next_multiple_of(ALIGNMENT) - unpadded;
    header.push_str(&" ".repeat(padding));
    header.push('\n');

    let mut file = Vec::with_capacity(PREFIX + header.len() + N * values.len());
    file.extend_from_slice(b"\x93NUMPY\x01\x00");
    let length = u16::try_from(header.len()).map_err(|_| wrong())?;
    file.extend_from_slice(&length.to_le_bytes());
    file.extend_from_slice(header.as_bytes());
    file.extend(values.iter().flat_map(|value| bytes_of(*value)));
    Ok(file)
}

/// Numbers out of a NumPy file, in C order: the last index of the shape runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedArray {
    /// Its sides.
    pub shape: Vec<usize>,
    /// Its values, `f32` widened; NaN and infinities as they are.
    pub values: Vec<f64>,
}

/// The numbers in a NumPy file (`.npy`, versions 1 to 3): little-endian floats of 32 or 64 bits in C order.
/// `name` serves only for messages.
///
/// **Source**: as for [`encode_array`].
///
/// # Errors
/// [`DatasetError::BadArray`] for anything else: other magic, other kinds of values, Fortran order, pickled
/// objects, a header that is none, a shape that is not that of the bytes.
pub fn decode_array(name: &str, bytes: &[u8]) -> Result<DecodedArray, DatasetError> {
    decoded(bytes).map_err(|reason| DatasetError::BadArray {
        name: name.to_owned(),
        reason,
    })
}

fn decoded(bytes: &[u8]) -> Result<DecodedArray, String> {
    let (version, after) = match bytes.split_at_checked(8) {
        Some(([0x93, b'N', b'U', b'M', b'P', b'Y', version, _], after)) => (*version, after),
        _ => return Err("it does not begin like one".to_owned()),
    };
    let cut = || "it ends within its header".to_owned();
    let n_bytes = match version {
        1 => 2,
        2 | 3 => 4,
        _ => return Err(format!("version {version} is unknown")),
    };
    let (length, after) = after.split_at_checked(n_bytes).ok_or_else(cut)?;
    let length = length.iter().rev();
    let length = length.fold(0, |sum, byte| (sum << 8) | usize::from(*byte));
    let (header, data) = after.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "its header is no text".to_owned())?;
    let key = |key: &str| {
        let found = header.split_once(&format!("'{key}':"));
        found
            .map(|(_, value)| value.trim_start())
            .ok_or_else(|| format!("its header has no {key:?}"))
    };
    let quoted = key("descr")?.strip_prefix('\'');
    let kind = quoted.and_then(|rest| rest.split('\'').next());
    let kind = kind.unwrap_or("a structure");
    let width = match kind {
        "<f4" => 4,
        "<f8" => 8,
        _ => return Err(format!("its values are {kind:?}, not \"<f4\" or \"<f8\"")),
    };
    if !key("fortran_order")?.starts_with("False") {
        return Err("its first index runs fastest".to_owned());
    }
    let sides = key("shape")?.strip_prefix('(');
    let sides = sides.and_then(|rest| rest.split(')').next());
    let bad = || "its shape is not a tuple of whole numbers".to_owned();
    let sides = sides.ok_or_else(bad)?.split(',').map(str::trim);
    let sides = sides.filter(|side| !side.is_empty()).map(str::parse);
    let shape: Vec<usize> = sides.collect::<Result<_, _>>().map_err(|_| bad())?;
    let mut sides = shape.iter();
    if sides.try_fold(width, |n: usize, side| n.checked_mul(*side)) != Some(data.len()) {
        return Err(format!(
            "its shape {shape:?} of {kind:?} is not that of {} bytes",
            data.len()
        ));
    }
    let values = if width == 4 {
        let (words, _) = data.as_chunks();
        words
            .iter()
            .map(|word| f64::from(f32::from_le_bytes(*word)))
            .collect()
    } else {
        let (words, _) = data.as_chunks();
        words.iter().map(|word| f64::from_le_bytes(*word)).collect()
    };
    Ok(DecodedArray { shape, values })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    /// What NumPy 2.4.6 writes for `numpy.save(f, numpy.arange(6, dtype="<f4").reshape(shape))`.
    #[test]
    fn the_file_is_the_one_that_numpy_writes() {
        let values: [f32; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        for (shape, tuple) in [(&[1, 3, 2][..], "(1, 3, 2)"), (&[6], "(6,)")] {
            let file = encode_array(shape, &values).unwrap();
            let text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {tuple}, }}");
            let mut expected = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
            expected.extend_from_slice(format!("{text:117}\n").as_bytes());
            expected.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            assert_eq!(file, expected, "{tuple}, byte by byte");
        }
    }

    #[test]
    fn numbers_begin_at_a_multiple_of_64_whatever_the_shape() {
        for side in [1, 10, 100, 1000, 10_000, 100_000] {
            let values = vec![0.5; side];
            for shape in [vec![side], vec![side, 1], vec![1, side, 1, 1]] {
                let file = encode_array(&shape, &values).unwrap();
                assert_eq!((file.len() - 4 * side) % 64, 0, "{shape:?}");
            }
        }
    }

    #[test]
    fn what_was_written_is_read() {
        let values: [f32; 6] = [0.0, 1.0, 2.0, 3.0, 4.0, f32::INFINITY];
        let wide = values.map(f64::from);
        for file in [
            encode_array(&[2, 3], &values).unwrap(),
            encode_array_f64(&[2, 3], &wide).unwrap(),
        ] {
            let array = decode_array("a.npy", &file).unwrap();
            assert_eq!(array.shape, [2, 3], "its shape");
            assert_eq!(array.values, wide, "its values");
        }
    }

    #[test]
    fn what_is_no_array_of_floats_is_refused_in_one_line() {
        let of = |descr: &str, shape: &str, n: usize| {
            let text =
                format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
            let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
            file.extend_from_slice(format!("{text:117}\n").as_bytes());
            file.extend(vec![0; n]);
            decode_array("x.npy", &file).unwrap_err().to_string()
        };
        let cases = [
            (
                of("<f2", "(2,)", 4),
                "its values are \"<f2\", not \"<f4\" or \"<f8\"",
            ),
            (
                of("|O", "(2,)", 16),
                "its values are \"|O\", not \"<f4\" or \"<f8\"",
            ),
            (
                of("<f4", "(2, 3)", 20),
                "its shape [2, 3] of \"<f4\" is not that of 20 bytes",
            ),
            (
                of("<f4", "(99999999999, 99999999999)", 0),
                "its shape [99999999999, 99999999999] of \"<f4\" is not that of 0 bytes",
            ),
            (
                of("<f4", "(-1,)", 4),
                "its shape is not a tuple of whole numbers",
            ),
            (
                decode_array("x.npy", b"PK\x03\x04")
                    .unwrap_err()
                    .to_string(),
                "it does not begin like one",
            ),
            (
                decode_array("x.npy", b"\x93NUMPY\x01\x00\xff\xff{")
                    .unwrap_err()
                    .to_string(),
                "it ends within its header",
            ),
        ];
        for (got, reason) in cases {
            let expected = format!(
                "\"x.npy\" is not a NumPy file of floats: {reason}; write it with numpy.save of numpy.ascontiguousarray(x, \"<f4\")"
            );
            assert_eq!(got, expected, "why");
        }
    }

    #[test]
    fn a_shape_of_other_values_is_refused() {
        let error = encode_array(&[2, 2], &[0.0; 3]).unwrap_err().to_string();
        assert_eq!(error, "an array of shape [2, 2] does not hold 3 values");
    }
}
