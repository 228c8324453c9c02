//! The transfer function itself, in arithmetic that is exact to the rounding of f64 everywhere.

/// Light of an encoded value between 0 and 1.
///
/// Only +, −, ×, ÷ are used, so the compiler can fill tables with it and every machine gets the
/// same bits: b^2.4 = b² (b²)^(1/5).
pub(super) const fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        let base = (encoded + 0.055) / 1.055;
        base * base * fifth_root(base * base)
    }
}

/// x^(1/5) of 0 < x ≤ 1 by Newton's method, which comes down from above.
const fn fifth_root(x: f64) -> f64 {
    // The tangent at 1, above the root as the root is concave.
    let mut root = 1.0 + (x - 1.0) / 5.0;
    loop {
        let square = root * root;
        let next = root - (square * square * root - x) / (5.0 * square * square);
        if next >= root {
            return root;
        }
        root = next;
    }
}
