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
    fn a_shape_of_other_values_is_refused() {
        let error = encode_array(&[2, 2], &[0.0; 3]).unwrap_err().to_string();
        assert_eq!(error, "an array of shape [2, 2] does not hold 3 values");
    }
}
