//! What is tried after a run of the loop: more smoothing where the curve crosses itself, last steps near the minimum.

use super::work::{SMOOTHER, State, Work};
use crate::options::Smoothing;
use crate::{Error, Status};
use distance_field::ErrorTerm;
use nurbs_core::BsplineCurve;
use sdm_core::StepControl;

/// Most iterations of a polish.
const POLISH: usize = 30;
/// Share of the size below which a fit is polished.
const NEARLY_EXACT: f64 = 1e-5;
/// Share by which finishing may raise the distance (for less energy).
const CREEP: f64 = 0.01;

impl<const D: usize> Work<'_, D> {
    /// Gauss-Newton steps where squared distance minimisation has come near the minimum but creeps along the curve
    /// (\[P05, sec. 4.3\]).
    pub(super) fn finished(&mut self, state: State<D>) -> Result<State<D>, Error> {
        let creeps = state.report.status == Status::MaxIterations
            && matches!(self.options.fit.smoothing, Smoothing::Automatic { .. })
            && state.report.history.len() >= self.options.fit.max_iterations
            && self.options.fit.term == ErrorTerm::SquaredDistance;
        if !creeps || self.cancelled {
            return Ok(state);
        }
        let fit = self
            .loop_options()
            .with_smoothing(Smoothing::Fixed { lambda: state.report.lambda })
            .with_term(ErrorTerm::Tangent);
        let next = self.run(state.curve.clone(), &fit, "finish")?;
        let better =
            next.report.rms <= state.report.rms * (1.0 + CREEP) && next.report.status != Status::Diverged;
        let crosses = self.crossings(&next.curve) > self.crossings(&state.curve);
        Ok(if better && !crosses { next } else { state })
    }

    /// More smoothing if the curve crosses itself and the start did not; only where the smoothing is chosen by the program.
    pub(super) fn uncrossed(
        &mut self,
        state: State<D>,
        start: &BsplineCurve<D>,
        crossed: bool,
    ) -> Result<State<D>, Error> {
        let Smoothing::Automatic { start: first, factor } = self.options.fit.smoothing else {
            return Ok(state);
        };
        if crossed || self.cancelled || self.crossings(&state.curve) == 0 {
            return Ok(state);
        }
        let from = state.report.lambda.max(1e-5);
        for more in SMOOTHER {
            let floor = from * more;
            let smoothing = Smoothing::Continuation { start: first.max(floor), factor, floor };
            let fit = self.loop_options().with_smoothing(smoothing);
            let next = self.run(start.clone(), &fit, "uncross")?;
            if self.cancelled || self.crossings(&next.curve) == 0 {
                return Ok(next);
            }
        }
        Ok(state)
    }

    /// A few Gauss-Newton steps without energy, where the points lie on the curve but for rounding.
    pub(super) fn polished(&mut self, state: State<D>) -> Result<State<D>, Error> {
        let nearly = state.report.rms <= NEARLY_EXACT * self.size && state.report.rms > 0.0;
        let automatic = matches!(self.options.fit.smoothing, Smoothing::Automatic { .. });
        if !nearly || !automatic || self.cancelled {
            return Ok(state);
        }
        let fit = self
            .loop_options()
            .with_smoothing(Smoothing::NONE)
            .with_term(ErrorTerm::Tangent)
            .with_control(StepControl::LevenbergMarquardt)
            .with_max_iterations(self.options.fit.max_iterations.min(POLISH));
        let mut next = self.run(state.curve.clone(), &fit, "polish")?;
        // What has converged only becomes better by this, however far it goes.
        if next.report.status == Status::MaxIterations && state.report.status == Status::Converged {
            next.report.status = Status::Converged;
        }
        if next.report.rms < state.report.rms && next.report.max <= state.report.max {
            self.keep(&next);
            return Ok(next);
        }
        Ok(state)
    }
}
