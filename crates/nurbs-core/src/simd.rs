//! Numbers in lanes: the same arithmetic on one parameter or on several at once.
//!
//! Only plain additions, subtractions, multiplications and divisions are offered, no fused ones: every
//! width of vector, and the single number, gives the same bits. The only file that knows `pulp`.

use pulp::{Arch, Simd, WithSimd};

/// A way to compute on `COUNT` numbers at once.
pub(crate) trait Lanes: Copy {
    /// `COUNT` numbers.
    type V: Copy;
    /// How many numbers one value holds.
    const COUNT: usize;
    /// The same number in every lane.
    fn splat(self, x: f64) -> Self::V;
    /// The first `COUNT` numbers of a slice that has as many.
    fn load(self, from: &[f64]) -> Self::V;
    /// Writes the lanes to the front of a slice that has room for them.
    fn store(self, x: Self::V, to: &mut [f64]);
    /// `a + b`.
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a − b`.
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a · b`.
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a / b`.
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
}

/// A single number.
#[derive(Clone, Copy)]
pub(crate) struct One;

impl Lanes for One {
    type V = f64;
    const COUNT: usize = 1;
    #[inline(always)]
    fn splat(self, x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn load(self, from: &[f64]) -> f64 {
        from[0]
    }
    #[inline(always)]
    fn store(self, x: f64, to: &mut [f64]) {
        to[0] = x;
    }
    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f64, b: f64) -> f64 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f64, b: f64) -> f64 {
        a * b
    }
    #[inline(always)]
    fn div(self, a: f64, b: f64) -> f64 {
        a / b
    }
}

/// The vectors of one instruction set.
#[derive(Clone, Copy)]
struct Wide<S>(S);

impl<S: Simd> Lanes for Wide<S> {
    type V = S::f64s;
    const COUNT: usize = S::F64_LANES;
    #[inline(always)]
    fn splat(self, x: f64) -> S::f64s {
        self.0.splat_f64s(x)
    }
    #[inline(always)]
    fn load(self, from: &[f64]) -> S::f64s {
        S::as_simd_f64s(from).0[0]
    }
    #[inline(always)]
    fn store(self, x: S::f64s, to: &mut [f64]) {
        S::as_mut_simd_f64s(to).0[0] = x;
    }
    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }
    #[inline(always)]
    fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.sub_f64s(a, b)
    }
    #[inline(always)]
    fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }
    #[inline(always)]
    fn div(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.div_f64s(a, b)
    }
}

/// The widest vectors that [`Lanes::COUNT`] stands for on any machine.
pub(crate) const MAX_LANES: usize = 8;

/// Work that is written once for every width. Its functions must be `#[inline(always)]`, or they are
/// compiled for the smallest instruction set.
pub(crate) trait Kernel {
    /// Does the work.
    fn run<L: Lanes>(self, lanes: L);
}

struct Adapter<K>(K);

impl<K: Kernel> WithSimd for Adapter<K> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(Wide(simd));
    }
}

/// Runs a kernel with the widest vectors of the machine it runs on.
pub(crate) fn dispatch(kernel: impl Kernel) {
    Arch::new().dispatch(Adapter(kernel));
}

/// One of the widths that this machine has.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) enum Width {
    One,
    Scalar,
    #[cfg(target_arch = "x86_64")]
    V3(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    V4(pulp::x86::V4),
}

#[cfg(test)]
impl Width {
    /// All of them.
    pub(crate) fn all() -> Vec<Self> {
        let mut all = vec![Self::One, Self::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Self::V3));
            all.extend(pulp::x86::V4::try_new().map(Self::V4));
        }
        all
    }

    /// Runs a kernel at this width.
    pub(crate) fn run(self, kernel: impl Kernel) {
        match self {
            Self::One => kernel.run(One),
            Self::Scalar => Simd::vectorize(pulp::Scalar, Adapter(kernel)),
            #[cfg(target_arch = "x86_64")]
            Self::V3(simd) => Simd::vectorize(simd, Adapter(kernel)),
            #[cfg(target_arch = "x86_64")]
            Self::V4(simd) => Simd::vectorize(simd, Adapter(kernel)),
        }
    }
}
