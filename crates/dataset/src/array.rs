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

/// The numbers in a NumPy file (`.npy`, versions 1 to 3): floats of 16, 32 or 64 bits of either byte
/// order, in C or Fortran order. `name` serves only for messages.
///
/// **Source**: as for [`encode_array`].
///
/// # Errors
/// [`DatasetError::BadArray`] for anything else: other magic, other kinds of values, pickled objects,
/// a header that is none, a shape that is not that of the bytes.
pub fn decode_array(name: &str, bytes: &[u8]) -> Result<DecodedArray, DatasetError> {
    let refuse = |reason: String| DatasetError::BadArray {
        name: name.to_owned(),
        reason,
    };
    let (version, after) = match bytes.split_at_checked(8) {
        Some(([0x93, b'N', b'U', b'M', b'P', b'Y', version, _], after)) => (*version, after),
        _ => return Err(refuse("it does not begin like one".to_owned())),
    };
    let cut = || refuse("it ends within its header".to_owned());
    let (length, after) = match version {
        1 => {
            let (length, after) = after.split_first_chunk::<2>().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*length)), after)
        }
        2 | 3 => {
            let (length, after) = after.split_first_chunk::<4>().ok_or_else(cut)?;
            let length = u32::from_le_bytes(*length);
            (usize::try_from(length).map_err(|_| cut())?, after)
        }
        _ => return Err(refuse(format!("version {version} is unknown"))),
    };
    let (header, data) = after.split_at_checked(length).ok_or_else(cut)?;
    let header =
        std::str::from_utf8(header).map_err(|_| refuse("its header is no text".to_owned()))?;
    let key = |key: &str| {
        let found = header.split_once(&format!("'{key}':"));
        found
            .map(|(_, value)| value.trim_start())
            .ok_or_else(|| refuse(format!("its header has no {key:?}")))
    };
    let descr = key("descr")?;
    let kind = descr
        .strip_prefix('\'')
        .and_then(|rest| rest.split('\'').next())
        .unwrap_or("a structure");
    let width = match kind.trim_start_matches(['<', '>', '=', '|']) {
        "f2" => 2,
        "f4" => 4,
        "f8" => 8,
        _ => return Err(refuse(format!("its values are {kind:?}, not floats"))),
    };
    let is_fortran = key("fortran_order")?.starts_with("True");
    let shape = key("shape")?
        .strip_prefix('(')
        .and_then(|rest| rest.split(')').next())
        .map(|sides| {
            sides
                .split(',')
                .map(str::trim)
                .filter(|side| !side.is_empty())
        })
        .and_then(|sides| {
            sides
                .map(|side| side.parse().ok())
                .collect::<Option<Vec<usize>>>()
        })
        .ok_or_else(|| refuse("its shape is not a tuple of whole numbers".to_owned()))?;
    let n_bytes = shape
        .iter()
        .try_fold(width, |n: usize, side| n.checked_mul(*side));
    if n_bytes != Some(data.len()) {
        return Err(refuse(format!(
            "its shape {shape:?} of {kind:?} is not that of {} bytes",
            data.len()
        )));
    }
    let is_big = kind.starts_with('>');
    let stored: Vec<f64> = data
        .chunks_exact(width)
        .map(|bytes| float(bytes, is_big))
        .collect();
    let values = if is_fortran {
        c_order(&shape, &stored)
    } else {
        stored
    };
    Ok(DecodedArray { shape, values })
}

/// A float of 2, 4 or 8 bytes.
fn float(bytes: &[u8], is_big: bool) -> f64 {
    let mut little = [0; 8];
    for (at, slot) in little.iter_mut().enumerate().take(bytes.len()) {
        let from = if is_big { bytes.len() - 1 - at } else { at };
        *slot = bytes.get(from).copied().unwrap_or_default();
    }
    match (bytes.len(), little) {
        (2, [a, b, ..]) => half(u16::from_le_bytes([a, b])),
        (4, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::from_le_bytes(little),
    }
}

/// IEEE 754 binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from((bits >> 10) & 0x1f);
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match exponent {
        0 => libm::scalbn(fraction, -14),
        31 if fraction > 0.0 => f64::NAN,
        31 => f64::INFINITY,
        _ => libm::scalbn(1.0 + fraction, exponent - 15),
    }
}

/// Values whose first index runs fastest, with the last one fastest.
fn c_order(shape: &[usize], stored: &[f64]) -> Vec<f64> {
    let place = |mut at: usize| {
        // Indices from the last to the first, by what C order has.
        let mut from = 0;
        let mut stride = stored.len();
        for side in shape.iter().rev() {
            stride /= side.max(&1);
            from += (at % side) * stride;
            at /= side;
        }
        from
    };
    (0..stored.len())
        .filter_map(|at| stored.get(place(at)).copied())
        .collect()
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
    fn what_was_written_is_read_and_fortran_order_is_turned() {
        let file = encode_array(&[2, 3], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let array = decode_array("a.npy", &file).unwrap();
        assert_eq!(array.shape, [2, 3], "its shape");
        assert_eq!(array.values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0], "its values");
        // numpy.save of numpy.asfortranarray([[0, 1, 2], [3, 4, 5]]) of ">f8" has this header.
        let text = "{'descr': '>f8', 'fortran_order': True, 'shape': (2, 3), }";
        let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
        file.extend_from_slice(format!("{text:117}\n").as_bytes());
        file.extend(
            [0.0_f64, 3.0, 1.0, 4.0, 2.0, 5.0]
                .iter()
                .flat_map(|v| v.to_be_bytes()),
        );
        assert_eq!(decode_array("f.npy", &file).unwrap(), array, "turned");
        assert_eq!(
            half(0x3c01).to_bits(),
            1.000_976_562_5_f64.to_bits(),
            "binary16"
        );
        assert_eq!(
            half(0x0001).to_bits(),
            2_f64.powi(-24).to_bits(),
            "the least of binary16"
        );
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
            (of("<i8", "(2,)", 16), "its values are \"<i8\", not floats"),
            (of("|O", "(2,)", 16), "its values are \"|O\", not floats"),
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
                "\"x.npy\" is not a NumPy file of floats: {reason}; write it with numpy.save of a float32 or float64 array"
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
