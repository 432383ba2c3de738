//! Runtime choice of the instruction set.

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

/// Work that is written once for vectors of any width.
pub(crate) trait Task {
    /// Does the work, all of it `#[inline(always)]`.
    fn run<S: pulp::Simd>(self, simd: S);
}

/// Runs a task with the widest vectors of the machine.
#[inline]
pub(crate) fn dispatch(task: impl Task) {
    struct Op<T>(T);
    impl<T: Task> pulp::WithSimd for Op<T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, simd: S) {
            self.0.run(simd);
        }
    }
    pulp::Arch::new().dispatch(Op(task));
}
