//! Constructed cases whose answers are known from how they were made, and how far the program is from these answers.

mod cad;
mod files;
mod inspection;
mod projection;
mod registration;
mod shapes;
mod views;

use serde::Serialize;

/// Anything that can go wrong in a case.
type Failure = Box<dyn std::error::Error>;

/// One case: the answer that is certain, and how far from it the program is.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Check {
    /// What is tested.
    pub(crate) group: &'static str,
    /// The case.
    pub(crate) case: &'static str,
    /// Its answer, and why that is certain.
    pub(crate) certified: &'static str,
    /// Largest deviation from the answer; `null` if there was none to compare.
    pub(crate) deviation: f64,
    /// Largest deviation that is allowed.
    pub(crate) bound: f64,
    /// Whether it is kept.
    pub(crate) pass: bool,
    /// What went wrong instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
}

/// The cases so far.
#[derive(Debug, Default)]
struct Checks {
    list: Vec<Check>,
    group: &'static str,
}

impl Checks {
    /// Runs a case: `work` computes the deviation from the certified answer.
    fn add(
        &mut self,
        case: &'static str,
        certified: &'static str,
        bound: f64,
        work: impl FnOnce() -> Result<f64, Failure>,
    ) {
        let (deviation, error) = match work() {
            Ok(deviation) => (deviation, None),
            Err(error) => (f64::NAN, Some(error.to_string())),
        };
        // NaN passes nothing.
        let pass = deviation <= bound;
        self.list.push(Check { group: self.group, case, certified, deviation, bound, pass, error });
    }
}

/// One group of cases after the other; `before` hears how many are done, and of how many.
pub(crate) fn run(before: &dyn Fn(usize, usize)) -> Vec<Check> {
    type Group = (&'static str, fn(&mut Checks));
    let groups: [Group; 6] = [
        ("projection", projection::add),
        ("registration", registration::add),
        ("views", views::add),
        ("inspection", inspection::add),
        ("files", files::add),
        ("CAD", cad::add),
    ];
    let mut checks = Checks::default();
    for (done, (group, add)) in groups.into_iter().enumerate() {
        before(done, groups.len());
        checks.group = group;
        add(&mut checks);
    }
    checks.list
}

/// The largest of some numbers; NaN if one of them is.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most: f64, value| if most.is_nan() || value <= most { most } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_is_well() {
        for check in run(&|_, _| ()) {
            assert!(check.pass, "{check:?}");
        }
    }

    #[test]
    fn what_is_wrong_does_not_pass() {
        let mut checks = Checks::default();
        checks.add("too far", "0", 1e-9, || Ok(1e-8));
        checks.add("no number", "0", 1e-9, || Ok(f64::NAN));
        checks.add("no answer", "0", 1e-9, || Err("broken".into()));
        assert!(checks.list.iter().all(|check| !check.pass));
        assert_eq!(checks.list[2].error.as_deref(), Some("broken"));
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan() && largest([1.0, 3.0, 2.0]) == 3.0);
    }
}
