//! Numbers in lanes: the same arithmetic on one parameter or on several at once.
//!
//! Only plain additions, subtractions, multiplications and divisions are offered, no fused ones: every
//! width of vector, and the single number, gives the same bits. The only file that knows `pulp`.

#[cfg(not(debug_assertions))]
use pulp::Arch;
use pulp::{Simd, WithSimd, bytemuck};

/// A way to compute on `COUNT` numbers at once.
pub(crate) trait Lanes: Copy {
    /// `COUNT` numbers.
    type V: Copy;
    /// How many numbers one value holds.
    const COUNT: usize;
    /// Vectors of half the width where the machine has them, else the same: for what does not fill one.
    type Half: Lanes;
    /// These.
    fn half(self) -> Self::Half;
    /// The same number in every lane.
    fn splat(self, x: f64) -> Self::V;
    /// The first `COUNT` numbers of a slice that has as many.
    fn load(self, from: &[f64]) -> Self::V;
    /// Writes the lanes to the front of a slice that has room for them.
    fn store(self, x: Self::V, to: &mut [f64]);
    /// For every lane the numbers that four values have in it.
    fn store_quadruples(self, x: [Self::V; 4], to: &mut [[f64; 4]; MAX_LANES]);
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
    type Half = Self;
    #[inline(always)]
    fn half(self) -> Self {
        self
    }
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
    fn store_quadruples(self, x: [f64; 4], to: &mut [[f64; 4]; MAX_LANES]) {
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

/// The vectors of one instruction set, and those of another one that it contains.
#[derive(Clone, Copy)]
struct Wide<S, H>(S, H);

impl<S: Simd, H: Simd> Lanes for Wide<S, H> {
    type V = S::f64s;
    const COUNT: usize = S::F64_LANES;
    type Half = Wide<H, H>;
    #[inline(always)]
    fn half(self) -> Wide<H, H> {
        Wide(self.1, self.1)
    }
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
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of lanes")]
    #[inline(always)]
    fn store_quadruples(self, x: [S::f64s; 4], to: &mut [[f64; 4]; MAX_LANES]) {
        // They come in an order of the processor's own, which numbers of lanes show; known when this is compiled.
        let lanes = self.0.interleave_shfl_f64s([self.load(&LANES); 4]);
        let quadruples = self.0.interleave_shfl_f64s(x);
        let [lanes, quadruples] = [&lanes, &quadruples].map(|q| bytemuck::cast_slice::<_, [f64; 4]>(q));
        for k in 0..S::F64_LANES {
            to[lanes[k][0] as usize] = quadruples[k];
        }
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

/// The numbers of the lanes.
const LANES: [f64; MAX_LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

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
        self.0.run(Wide(simd, simd));
    }
}

/// Runs a kernel with the widest vectors of the machine it runs on. A debug build knows the plain ones only: the numbers are
/// the same, and a kernel compiles once instead of three times.
pub(crate) fn dispatch(kernel: impl Kernel) {
    #[cfg(debug_assertions)]
    Adapter(kernel).with_simd(pulp::Scalar);
    #[cfg(not(debug_assertions))]
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => with_halves(simd, kernel),
        arch => arch.dispatch(Adapter(kernel)),
    }
}

#[cfg(all(target_arch = "x86_64", any(test, not(debug_assertions))))]
fn with_halves(simd: pulp::x86::V4, kernel: impl Kernel) {
    simd.vectorize(
        #[inline(always)]
        || kernel.run(Wide(simd, *simd)),
    );
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
            Self::V4(simd) => with_halves(simd, kernel),
        }
    }
}
