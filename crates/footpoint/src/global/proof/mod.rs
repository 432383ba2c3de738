//! Lower bounds: that no point is nearer than the footpoint.

pub(crate) mod box_tests;
pub(crate) mod fine;
pub(crate) mod hulls;
pub(crate) mod line;
pub(crate) mod prove;
pub(crate) mod region;
pub(crate) mod split;
pub(crate) mod valley;
