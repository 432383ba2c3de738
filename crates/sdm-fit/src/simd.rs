//! Runtime choice of the instruction set (the only file that knows `pulp`).

/// Runs a closure compiled for the widest vector instructions of the machine. A debug build knows the plain ones only: the
/// numbers are the same, and it compiles once instead of three times.
///
/// What it calls must be `#[inline(always)]` to profit. The compiler does not fuse products and sums by itself, so that every
/// machine computes the same bits.
#[inline]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    struct Work<F>(F);
    impl<R, F: FnOnce() -> R> pulp::WithSimd for Work<F> {
        type Output = R;
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    #[cfg(debug_assertions)]
    return pulp::WithSimd::with_simd(Work(work), pulp::Scalar);
    #[cfg(not(debug_assertions))]
    pulp::Arch::new().dispatch(Work(work))
}
