//! Where a front may go, and how fast.

/// Obstacles and speed at the nodes of a grid. The default is free everywhere, of speed 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Medium {
    /// Whether a node is blocked; empty for none. Blocked nodes get no value.
    pub blocked: Vec<bool>,
    /// The speed at each node, positive; empty for 1 everywhere. Distances become times of arrival.
    pub speed: Vec<f64>,
}

impl Medium {
    /// Whether a node is blocked.
    #[must_use]
    pub fn is_blocked(&self, node: usize) -> bool {
        self.blocked.get(node).copied().unwrap_or(false)
    }

    /// One over the speed at a node.
    #[must_use]
    pub fn slowness(&self, node: usize) -> f64 {
        self.speed.get(node).map_or(1.0, |speed| 1.0 / speed)
    }
}
