//! Numbers side by side, as many as a vector of the machine holds, and the choice of the instruction set at run time (the only file
//! that knows `pulp`).
//!
//! Only plain sums, products and quotients are offered, no fused ones: every width gives the same bits.

#[cfg(any(test, debug_assertions))]
pub(crate) use pulp::Scalar;
pub(crate) use pulp::Simd;
use pulp::bytemuck;
use std::ops::{Add, Div, Mul, Sub};

/// Most numbers of a [`Pack`] on any machine.
pub(crate) const MOST: usize = 8;

/// `COUNT` numbers side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pack<S: Simd>(S, S::f64s);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $operation:ident) => {
        impl<S: Simd> $trait for Pack<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$operation(self.1, other.1))
            }
        }
    };
}
lanewise!(Add, add, add_f64s);
lanewise!(Sub, sub, sub_f64s);
lanewise!(Mul, mul, mul_f64s);
lanewise!(Div, div, div_f64s);

impl<S: Simd> Mul<f64> for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * self.all(factor)
    }
}

impl<S: Simd> Pack<S> {
    /// How many numbers it holds.
    pub(crate) const COUNT: usize = S::F64_LANES;

    /// The same number everywhere.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self(simd, simd.splat_f64s(value))
    }

    /// The same number everywhere, in as many places as here.
    #[inline(always)]
    pub(crate) fn all(self, value: f64) -> Self {
        Self::splat(self.0, value)
    }

    /// The first numbers of an array.
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[f64; MOST]) -> Self {
        Self(simd, S::as_simd_f64s(from).0[0])
    }

    /// Writes the numbers to the front of an array.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f64; MOST]) {
        S::as_mut_simd_f64s(to).0[0] = self.1;
    }

    /// The numbers, followed by zeros.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; MOST] {
        let mut out = [0.0; MOST];
        self.store(&mut out);
        out
    }

    /// One of the numbers.
    #[inline(always)]
    pub(crate) fn at(&self, place: usize) -> f64 {
        bytemuck::cast_slice::<_, f64>(std::slice::from_ref(&self.1))[place]
    }

    /// The smaller number in each place; either where one is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0, self.0.min_f64s(self.1, other.1))
    }

    /// The larger number in each place; either where one is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f64s(self.1, other.1))
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0, self.0.abs_f64s(self.1))
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f64s(self.1))
    }

    /// Bit by bit, whether a number is positive.
    #[inline(always)]
    pub(crate) fn positive(self) -> u32 {
        bits(&self.0.less_than_f64s(self.all(0.0).1, self.1))
    }

    /// Bit by bit, whether a number is positive or zero.
    #[inline(always)]
    pub(crate) fn not_negative(self) -> u32 {
        bits(&self.0.less_than_or_equal_f64s(self.all(0.0).1, self.1))
    }
}

/// A mask as bits: it is kept in one byte, or as one word of ones or zeros for each number.
#[inline(always)]
fn bits<M: bytemuck::NoUninit>(mask: &M) -> u32 {
    match bytemuck::bytes_of(mask) {
        [bits] => u32::from(*bits),
        words => (0..)
            .zip(words.chunks_exact(8))
            .fold(0, |all, (place, word)| all | u32::from(word[0] & 1) << place),
    }
}

/// Runs work with the widest vector instructions of the machine. A debug build knows the plain ones only: the numbers are the
/// same, and the search, which is inlined into every caller, compiles once instead of three times.
#[inline]
fn with_widest<W: pulp::WithSimd>(work: W) -> W::Output {
    #[cfg(debug_assertions)]
    return work.with_simd(Scalar);
    #[cfg(not(debug_assertions))]
    pulp::Arch::new().dispatch(work)
}

/// Runs `op` compiled for the widest vector instructions of the machine.
///
/// Everything that `op` calls must be `#[inline(always)]` to profit. Only plain products and sums are
/// used inside, never fused ones, so that every machine computes the same bits.
#[inline]
pub(crate) fn vectorized<R>(op: impl FnOnce() -> R) -> R {
    struct Op<F>(F);
    impl<R, F: FnOnce() -> R> pulp::WithSimd for Op<F> {
        type Output = R;
        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    with_widest(Op(op))
}

/// Work that is written once for vectors of any width.
pub(crate) trait Task {
    /// Does the work, all of it `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S);
}

/// Runs a task with the widest vectors of the machine.
#[inline]
pub(crate) fn dispatch(task: impl Task) {
    struct Op<T>(T);
    impl<T: Task> pulp::WithSimd for Op<T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.run(simd);
        }
    }
    with_widest(Op(task));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<S: Simd>(simd: S) {
        let values = [1.5, -0.0, -2.0, f64::NAN, 0.0, 4.0, -1e-300, f64::INFINITY];
        let pack = Pack::load(simd, &values);
        let seen = |test: fn(f64) -> bool| {
            (0..Pack::<S>::COUNT)
                .filter(|&place| test(values[place]))
                .fold(0u32, |all, place| all | 1 << place)
        };
        assert_eq!(pack.positive(), seen(|x| x > 0.0));
        assert_eq!(pack.not_negative(), seen(|x| x >= 0.0));
        let mut out = [0.0; MOST];
        ((pack * 3.0 + pack.all(1.0)) / pack.all(7.0)).store(&mut out);
        for place in 0..Pack::<S>::COUNT {
            let expected = (values[place] * 3.0 + 1.0) / 7.0;
            assert_eq!(out[place].to_bits(), expected.to_bits(), "{place}");
            assert_eq!(pack.at(place).to_bits(), values[place].to_bits());
            assert_eq!(pack.abs().sqrt().at(place).to_bits(), values[place].abs().sqrt().to_bits());
        }
        assert_eq!((pack.min(pack.all(1.0)).at(0), pack.max(pack.all(2.0)).at(0)), (1.0, 2.0));
    }

    #[test]
    fn every_width_computes_the_same() {
        check(Scalar);
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(simd) = pulp::x86::V3::try_new() {
                check(simd);
            }
            if let Some(simd) = pulp::x86::V4::try_new() {
                check(simd);
            }
        }
    }
}
