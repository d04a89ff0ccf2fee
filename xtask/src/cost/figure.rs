//! One number of the table.

/// What the firmware or a library costs, in instructions or bytes, on the target.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figure {
    /// What it is: the key of the baseline.
    pub(crate) name: String,
    /// How much it is.
    pub(crate) value: f64,
    /// What it should not exceed, where that is set.
    pub(crate) target: Option<f64>,
    /// The command that prints it.
    pub(crate) command: String,
}

impl Figure {
    /// A figure without a target.
    pub(crate) fn new(name: impl Into<String>, value: f64, command: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            // More digits would only be noise in the baseline.
            value: (10.0 * value).round() / 10.0,
            target: None,
            command: command.into(),
        }
    }

    /// The same with what it should not exceed.
    pub(crate) fn at_most(self, target: f64) -> Self {
        Self {
            target: Some(target),
            ..self
        }
    }

    /// `met`, or by how much it was missed; nothing without a target.
    pub(crate) fn verdict(&self) -> Option<String> {
        let target = self.target?;
        Some(if self.value <= target {
            "met".to_owned()
        } else {
            format!("missed, {:.1} times the target", self.value / target)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_that_is_missed_says_by_how_much() {
        let figure = |value| Figure::new("a cycle", value, "cargo xtask cost").at_most(5_000.0);
        assert_eq!(figure(5_000.0).verdict().as_deref(), Some("met"));
        let missed = figure(7_500.0).verdict();
        assert_eq!(missed.as_deref(), Some("missed, 1.5 times the target"));
        assert_eq!(Figure::new("a cycle", 1.0, "").verdict(), None);
    }
}
