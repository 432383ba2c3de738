//! Arguments of the loop that all fits share.

use clap::ValueEnum;
use industrial_geometry::distance_field::{ErrorTerm, Kernel};
use industrial_geometry::fit::{FitOptions, Robust, Smoothing, StepControl};

/// How steps are made and judged.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Options of the iteration")]
pub(crate) struct LoopArgs {
    /// What is minimised in a step
    #[arg(long, visible_alias = "method", value_enum, default_value_t = TermChoice::SquaredDistance)]
    term: TermChoice,
    /// How the length of steps is controlled
    #[arg(long = "step-control", alias = "control", value_enum, default_value_t = ControlChoice::Armijo)]
    control: ControlChoice,
    /// Factor of the bending energy: auto (asked from the data), continuation (to 0), or the least value (a number) [default: auto for
    /// curves and surfaces, otherwise 1e-8]
    #[arg(long, value_name = "LAMBDA", value_parser = parse_smoothing)]
    smoothing: Option<Smoothing>,
    /// What is assumed about points that do not belong to the shape
    #[arg(long, value_enum, default_value_t = OutlierChoice::None)]
    outliers: OutlierChoice,
    /// Most iterations between changes of the knots [default: 100, of ruled surfaces 200]; a fit that they end is not converged (exit status 1), unless a
    /// tolerance was asked for and holds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    max_iterations: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TermChoice {
    /// Squared distance minimisation (SDM)
    #[value(alias = "sdm")]
    SquaredDistance,
    /// The same with weights that stay positive on both sides of the shape
    Ratio,
    /// Squared distance to the tangent line or plane (TDM)
    #[value(alias = "tdm")]
    Tangent,
    /// Squared distance to the footpoint (PDM): slow
    #[value(alias = "pdm")]
    Point,
    /// Second order Taylor polynomial, which may be indefinite
    Taylor,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ControlChoice {
    /// Steps are shortened until they lower the cost
    Armijo,
    /// Steps are damped until they lower the cost
    LevenbergMarquardt,
    /// Full steps; may diverge
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutlierChoice {
    /// There are none: least squares over all points
    None,
    /// Recognised by their distances (Tukey's biweight)
    Automatic,
}

/// `auto`, `continuation`, or a number.
fn parse_smoothing(text: &str) -> Result<Smoothing, String> {
    match text {
        "auto" => Ok(Smoothing::default()),
        "continuation" => Ok(Smoothing::CONTINUATION),
        _ => match text.parse::<f64>() {
            Ok(floor) if floor >= 0.0 && floor.is_finite() => {
                Ok(Smoothing::Continuation { start: floor.max(1e-2), factor: 0.5, floor })
            }
            _ => Err("give auto, continuation, or a number of at least 0".to_owned()),
        },
    }
}

impl LoopArgs {
    /// The options of a shape with what was typed in place of its own.
    pub(crate) fn applied_to(&self, options: FitOptions) -> FitOptions {
        let term = match self.term {
            TermChoice::SquaredDistance => ErrorTerm::SquaredDistance,
            TermChoice::Ratio => ErrorTerm::SquaredDistanceRatio,
            TermChoice::Tangent => ErrorTerm::Tangent,
            TermChoice::Point => ErrorTerm::Point,
            TermChoice::Taylor => ErrorTerm::Taylor,
        };
        let control = match self.control {
            ControlChoice::Armijo => StepControl::Armijo,
            ControlChoice::LevenbergMarquardt => StepControl::LevenbergMarquardt,
            ControlChoice::None => StepControl::None,
        };
        let robust = match self.outliers {
            OutlierChoice::None => Robust::None,
            OutlierChoice::Automatic => Robust::Kernel { kernel: Kernel::Tukey, abs_scale: None },
        };
        options
            .with_term(term)
            .with_control(control)
            .with_robust(robust)
            .with_smoothing(self.smoothing.unwrap_or(options.smoothing))
            .with_max_iterations(self.max_iterations.map_or(options.max_iterations, usize::from))
    }
}
