//! Numbers of one ray, or of several that are followed side by side.

use std::array;
use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

/// A number of one ray or of each of several, so that what becomes of light is written once. Several are worked on as each
/// alone would be, to the bit: nothing is fused, and nothing depends on how many there are.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// One that is the same of all rays that `self` is of.
    fn all(self, value: f64) -> Self;

    fn sqrt(self) -> Self;

    /// Where this is below another, the first of two; elsewhere the second.
    fn below(self, other: Self, two: [Self; 2]) -> Self;

    /// Whether this is above a number anywhere, and whether it is below it everywhere.
    fn is_above(self, value: f64) -> bool;
    fn are_below(self, value: f64) -> bool;

    /// Of each ray, what a function makes of two numbers.
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self;

    #[inline(always)]
    fn at_least(self, least: f64) -> Self {
        let least = self.all(least);
        self.below(least, [least, self])
    }

    #[inline(always)]
    fn at_most(self, most: f64) -> Self {
        let most = self.all(most);
        most.below(self, [most, self])
    }

    /// What is beyond the next lower whole number, of numbers up to 2⁵¹.
    #[inline(always)]
    fn fraction(self) -> Self {
        // The sum has no place for what is less than 1.
        let round = self.all(1.5 * (1_u64 << 52) as f64);
        let nearest = self + round - round;
        let beyond = self - nearest;
        beyond.below(self.all(0.0), [beyond + self.all(1.0), beyond])
    }

    /// A number, times this.
    #[inline(always)]
    fn times(self, value: f64) -> Self {
        self.all(value) * self
    }

    /// A number, less this.
    #[inline(always)]
    fn less_from(self, value: f64) -> Self {
        self.all(value) - self
    }
}

impl Number for f64 {
    #[inline(always)]
    fn all(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn below(self, other: Self, [then, otherwise]: [Self; 2]) -> Self {
        if self < other { then } else { otherwise }
    }

    #[inline(always)]
    fn is_above(self, value: f64) -> bool {
        self > value
    }

    #[inline(always)]
    fn are_below(self, value: f64) -> bool {
        self < value
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        of(self, other)
    }
}

/// Most rays that any processor follows side by side.
pub(crate) const MOST_LANES: usize = 8;

/// As many numbers as a processor works on at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Several<S: Simd>(S, S::f64s);

impl<S: Simd> Several<S> {
    /// The same number of all.
    #[inline(always)]
    pub(crate) fn all_of(simd: S, value: f64) -> Self {
        Self(simd, simd.splat_f64s(value))
    }

    /// Those of a slice; 0 beyond its end.
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[f64]) -> Self {
        Self(simd, simd.partial_load_f64s(from))
    }

    /// Into a slice, as far as it reaches.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f64]) {
        self.0.partial_store_f64s(to, self.1);
    }

    #[inline(always)]
    fn each(self) -> [f64; MOST_LANES] {
        let mut each = [0.0; MOST_LANES];
        self.store(&mut each);
        each
    }
}

macro_rules! operator {
    ($operator:ident, $name:ident, $of:ident) => {
        impl<S: Simd> $operator for Several<S> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0, self.0.$of(self.1, other.1))
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Number for Several<S> {
    #[inline(always)]
    fn all(self, value: f64) -> Self {
        Self::all_of(self.0, value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f64s(self.1))
    }

    #[inline(always)]
    fn below(self, other: Self, [then, otherwise]: [Self; 2]) -> Self {
        let is_below = self.0.less_than_f64s(self.1, other.1);
        Self(self.0, self.0.select_f64s(is_below, then.1, otherwise.1))
    }

    #[inline(always)]
    fn is_above(self, value: f64) -> bool {
        let is_above = self.0.less_than_f64s(self.all(value).1, self.1);
        self.0.first_true_m64s(is_above) < S::F64_LANES
    }

    #[inline(always)]
    fn are_below(self, value: f64) -> bool {
        let is_not = (self.0).less_than_or_equal_f64s(self.all(value).1, self.1);
        self.0.first_true_m64s(is_not) >= S::F64_LANES
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let (these, others) = (self.each(), other.each());
        let made: [f64; MOST_LANES] = array::from_fn(|k| match k < S::F64_LANES {
            true => of(these[k], others[k]),
            false => 0.0,
        });
        Self::load(self.0, &made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some of all that is done to numbers of rays.
    fn mixed<N: Number>([a, b]: [N; 2]) -> [N; 8] {
        [
            a * b - a / b + (a * a).sqrt(),
            a.below(b, [a.times(3.0), b]),
            a.at_least(0.25),
            a.at_most(0.25),
            b.less_from(1.0),
            a.times(1e3).fraction(),
            a.with(b, |a, b| a.mul_add(2.0, b)),
            a.all(if a.is_above(1e9) || !a.are_below(1e9) {
                1.0
            } else {
                0.0
            }),
        ]
    }

    struct Mixed<'a>(&'a [[f64; MOST_LANES]; 2], &'a mut [[f64; MOST_LANES]; 8]);

    impl pulp::WithSimd for Mixed<'_> {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            for first in (0..MOST_LANES).step_by(S::F64_LANES) {
                let of = |all: &[f64; MOST_LANES]| Several::load(simd, &all[first..]);
                for (to, all) in self.1.iter_mut().zip(mixed(self.0.each_ref().map(of))) {
                    all.store(&mut to[first..]);
                }
            }
        }
    }

    #[test]
    fn several_numbers_are_worked_on_as_each_alone() {
        let of = |k: usize, by: f64| libm::sin(by * (k as f64 + 1.0));
        for round in 0..200_u32 {
            let by = [0.7, 1.3].map(|by| by * f64::from(round + 1));
            let numbers = by.map(|by| array::from_fn(|k| of(k, by)));
            let mut found = [[0.0; MOST_LANES]; 8];
            pulp::Arch::new().dispatch(Mixed(&numbers, &mut found));
            let mut scalar = [[0.0; MOST_LANES]; 8];
            pulp::WithSimd::with_simd(Mixed(&numbers, &mut scalar), pulp::Scalar::new());
            for k in 0..MOST_LANES {
                let alone = mixed(numbers.each_ref().map(|all| all[k]));
                for (l, alone) in alone.into_iter().enumerate() {
                    for (what, all) in [("side by side", &found), ("one by one", &scalar)] {
                        let (alone, all) = (alone.to_bits(), all[l][k].to_bits());
                        assert_eq!(alone, all, "{what}: number {k}, result {l}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_fraction_is_beyond_the_next_lower_whole_number() {
        for (number, beyond) in [
            (2.75, 0.75),
            (-2.75, 0.25),
            (3.0, 0.0),
            (1.5, 0.5),
            (2.5, 0.5),
            (-2.5, 0.5),
        ] {
            let found = number.fraction();
            assert!((found - beyond).abs() < 1e-15, "{number}: {found}");
        }
    }
}
