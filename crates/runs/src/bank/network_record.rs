//! A crack network as a record: the same network to the bit.
//!
//! It is the network's JSON with its long columns taken out of it: numbers as their 64 bits, byte
//! by byte of all of them together, so that what is alike lies together; indices as differences;
//! words as numbers of a list. So a column that is new in the JSON is kept without a change here.

use serde_json::{Map, Value};
use starbreak_glass::{CrackNetwork, NetworkData};

/// Shorter lists stay in the JSON.
const MIN_COLUMN: usize = 8;

/// Key by which a column that was taken out is known, and that of its length.
const KIND: &str = "$column";
const LENGTH: &str = "n";
const WORDS: &str = "words";

/// Kinds of columns.
const NUMBERS: &str = "f64";
const INDICES: &str = "index";
const LISTED: &str = "word";

/// The record of a network.
pub(super) fn network_to_bytes(network: &CrackNetwork) -> Vec<u8> {
    // Plain numbers, strings and lists, every number finite: this cannot fail.
    let mut json = serde_json::to_value(network.data()).unwrap_or_default();
    let mut columns = Vec::new();
    take_out(&mut json, &mut columns);
    let text = serde_json::to_vec(&json).unwrap_or_default();
    let n = u32::try_from(text.len()).unwrap_or(u32::MAX);
    let mut out = n.to_le_bytes().to_vec();
    out.extend_from_slice(&text);
    out.extend_from_slice(&columns);
    out
}

/// The network of a record, checked in full, or what is wrong with it.
pub(super) fn network_of_bytes(bytes: &[u8]) -> Result<CrackNetwork, String> {
    let (n, rest) = bytes.split_first_chunk::<4>().ok_or("it is too short")?;
    let (text, mut columns) = rest
        .split_at_checked(u32::from_le_bytes(*n) as usize)
        .ok_or("it ends in its text")?;
    let mut json: Value = serde_json::from_slice(text).map_err(|cause| cause.to_string())?;
    put_back(&mut json, &mut columns)?;
    if !columns.is_empty() {
        return Err("bytes are left over".to_owned());
    }
    let data: NetworkData = serde_json::from_value(json).map_err(|cause| cause.to_string())?;
    CrackNetwork::new(data).map_err(|cause| cause.to_string())
}

/// Replaces the long lists in a value, depth first, and appends what was in them.
fn take_out(value: &mut Value, out: &mut Vec<u8>) {
    match value {
        Value::Object(map) => map.values_mut().for_each(|value| take_out(value, out)),
        Value::Array(list) if list.len() >= MIN_COLUMN => {
            if let Some(stub) = column(list, out) {
                *value = Value::Object(stub);
            }
        }
        _ => {}
    }
}

/// A list as a column, and what stands for it in the JSON; `None` for other lists.
fn column(list: &[Value], out: &mut Vec<u8>) -> Option<Map<String, Value>> {
    let stub = |kind: &str| {
        Map::from_iter([
            (KIND.to_owned(), kind.into()),
            (LENGTH.to_owned(), list.len().into()),
        ])
    };
    let numbers: Option<Vec<u64>> = list
        .iter()
        .map(|value| match value {
            Value::Number(number) if number.is_f64() => number.as_f64().map(f64::to_bits),
            _ => None,
        })
        .collect();
    if let Some(numbers) = numbers {
        for byte in (0..8).rev() {
            out.extend(numbers.iter().map(|bits| bits.to_le_bytes()[byte]));
        }
        return Some(stub(NUMBERS));
    }
    // Nothing is 0, an index one more than it is.
    let indices: Option<Vec<i64>> = list
        .iter()
        .map(|value| match value {
            Value::Null => Some(0),
            value => {
                let index = value.as_u64().and_then(|index| u32::try_from(index).ok())?;
                Some(i64::from(index) + 1)
            }
        })
        .collect();
    if let Some(indices) = indices {
        let mut last = 0;
        for index in indices {
            let step: i64 = index - last;
            last = index;
            write_step(out, step);
        }
        return Some(stub(INDICES));
    }
    let words: Option<Vec<&str>> = list.iter().map(Value::as_str).collect();
    let words = words?;
    let mut known: Vec<&str> = Vec::new();
    let mut numbers = Vec::with_capacity(words.len());
    for word in words {
        let at = known.iter().position(|other| *other == word);
        let at = at.unwrap_or_else(|| {
            known.push(word);
            known.len() - 1
        });
        numbers.push(u8::try_from(at).ok()?);
    }
    let mut stub = stub(LISTED);
    stub.insert(WORDS.to_owned(), known.into());
    out.extend_from_slice(&numbers);
    Some(stub)
}

/// Puts the lists back that [`take_out`] took.
fn put_back(value: &mut Value, columns: &mut &[u8]) -> Result<(), String> {
    let Value::Object(map) = value else {
        return Ok(());
    };
    let Some(kind) = map.get(KIND).and_then(Value::as_str) else {
        return map
            .values_mut()
            .try_for_each(|value| put_back(value, columns));
    };
    let n = map.get(LENGTH).and_then(Value::as_u64);
    // Every entry takes a byte at least.
    let n = n
        .and_then(|n| usize::try_from(n).ok())
        .filter(|n| *n <= columns.len())
        .ok_or("a column is longer than what is there")?;
    let list = match kind {
        NUMBERS => numbers(n, columns)?,
        INDICES => indices(n, columns)?,
        LISTED => {
            let words = map.get(WORDS).and_then(Value::as_array);
            let (numbers, rest) = columns.split_at(n);
            *columns = rest;
            numbers
                .iter()
                .map(|at| words?.get(usize::from(*at)).cloned())
                .collect::<Option<Vec<Value>>>()
                .ok_or("a word is not in its list")?
        }
        _ => return Err(format!("it has a column of an unknown kind {kind:?}")),
    };
    *value = Value::Array(list);
    Ok(())
}

fn numbers(n: usize, columns: &mut &[u8]) -> Result<Vec<Value>, String> {
    let (bytes, rest) = n
        .checked_mul(8)
        .and_then(|n| columns.split_at_checked(n))
        .ok_or("it ends in a column of numbers")?;
    *columns = rest;
    let number = |k: usize| {
        let bits = (0..8).fold(0, |bits, byte| {
            bits << 8 | u64::from(bytes.get(byte * n + k).copied().unwrap_or_default())
        });
        serde_json::Number::from_f64(f64::from_bits(bits)).map(Value::Number)
    };
    (0..n)
        .map(number)
        .collect::<Option<_>>()
        .ok_or_else(|| "a number is not finite".to_owned())
}

fn indices(n: usize, columns: &mut &[u8]) -> Result<Vec<Value>, String> {
    let mut last = 0_i64;
    (0..n)
        .map(|_| {
            last = last.wrapping_add(read_step(columns).ok_or("it ends in a column of indices")?);
            match u32::try_from(last) {
                Ok(0) => Ok(Value::Null),
                Ok(index) => Ok((index - 1).into()),
                Err(_) => Err("an index is out of range".to_owned()),
            }
        })
        .collect()
}

/// Appends a difference in 7-bit groups, the least first, zigzag: 0, −1, 1, −2, …
fn write_step(out: &mut Vec<u8>, step: i64) {
    let mut rest = (step << 1 ^ step >> 63).cast_unsigned();
    while rest >= 0x80 {
        #[expect(clippy::cast_possible_truncation, reason = "seven bits")]
        out.push(rest as u8 & 0x7f | 0x80);
        rest >>= 7;
    }
    #[expect(clippy::cast_possible_truncation, reason = "seven bits")]
    out.push(rest as u8);
}

fn read_step(columns: &mut &[u8]) -> Option<i64> {
    let mut bits = 0_u64;
    for shift in (0..35).step_by(7) {
        let (byte, rest) = columns.split_first()?;
        *columns = rest;
        bits |= u64::from(byte & 0x7f) << shift;
        if *byte < 0x80 {
            return Some((bits >> 1).cast_signed() ^ -(bits & 1).cast_signed());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_all_kinds_come_back() {
        let json = serde_json::json!({
            "x": [0.1, -0.0, 1e-300, 5e-324, 1.797_693_134_862_315_7e308, 2.0, 3.5, -7.25, 1.0],
            "from": [0, 4_294_967_294_u32, 7, 7, 7, 8, 9, 10],
            "parent": [null, 0, null, 1, 2, 3, 4, 5],
            "kind": ["radial", "ring", "radial", "ring", "fork", "fork", "radial", "radial"],
            "mixed": [1, 2.5, 3, 4, 5, 6, 7, 8],
            "short": [1.5, 2.5],
            "nested": { "impacts": [{ "x": 1.0 }] },
        });
        let (mut changed, mut columns) = (json.clone(), Vec::new());
        take_out(&mut changed, &mut columns);
        for key in ["x", "from", "parent", "kind"] {
            assert!(changed[key].is_object(), "{key} was not taken out");
        }
        assert!(
            changed["mixed"].is_array(),
            "a list of both kinds of numbers stays"
        );
        let mut rest = columns.as_slice();
        put_back(&mut changed, &mut rest).unwrap_or_default();
        assert!(rest.is_empty(), "all is read");
        // As text: as values, 0.0 equals −0.0.
        assert_eq!(changed.to_string(), json.to_string(), "another value");
        for n in 0..columns.len() {
            let (mut cut, mut rest) = (json.clone(), &columns[..n]);
            take_out(&mut cut, &mut Vec::new());
            assert!(
                put_back(&mut cut, &mut rest).is_err(),
                "{n} bytes are enough"
            );
        }
    }
}
