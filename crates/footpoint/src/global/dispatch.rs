//! Runtime choice of the instruction set (the only file that knows `pulp`).

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
        fn with_simd<S: pulp::Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    pulp::Arch::new().dispatch(Op(op))
}
