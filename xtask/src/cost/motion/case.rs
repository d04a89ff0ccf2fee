//! One image with standing or moving axes, and drives that take some time to answer.

use serde_json::Value;

use crate::cost::figure::Figure;
use crate::emulator::Load;
use crate::images::Board;

/// The number of axes for which the targets of a cycle are given, and the largest number, for the targets of memory.
pub(super) const TARGET_AXES: usize = 8;
pub(super) const MOST_AXES: usize = 14;

/// One image with standing or moving axes.
pub(super) struct Case {
    pub(super) board: Board,
    pub(super) load: Load,
    pub(super) mean: f64,
    pub(super) worst: f64,
    pub(super) worst_without_line: f64,
    pub(super) masked: f64,
    /// Instructions of each context, by its name.
    pub(super) contexts: Vec<(String, f64)>,
}

impl Case {
    pub(super) fn read(board: Board, load: Load, figures: &Value) -> Option<Self> {
        let figure = |name: &str| figures[name].as_f64();
        let contexts = figures["contexts"].as_object()?.iter();
        let mut contexts: Vec<(String, f64)> = contexts
            .map(|(name, instructions)| Some((name.clone(), instructions.as_f64()?)))
            .collect::<Option<_>>()?;
        contexts.sort_by(|one, other| other.1.total_cmp(&one.1));
        Some(Self {
            board,
            load,
            mean: figure("mean")?,
            worst: figure("worst")?,
            worst_without_line: figure("worst_without_line")?,
            masked: figure("masked")?,
            contexts,
        })
    }

    pub(super) fn command(&self) -> String {
        let Load {
            axes,
            response_us,
            motion,
        } = self.load;
        let board = self.board.feature();
        let mut command = format!(
            "cargo xtask profile --axes {axes} --board {board} --response-us {response_us}"
        );
        if let Some(option) = motion.option() {
            command.push(' ');
            command.push_str(option);
        }
        command
    }

    pub(super) fn figures(&self) -> Vec<Figure> {
        let name = |what: &str| format!("{}, {}: {what}", self.board.feature(), self.load);
        [
            ("mean", self.mean),
            ("worst millisecond", self.worst),
            (
                "worst millisecond without a line of the log",
                self.worst_without_line,
            ),
            ("longest stretch with interrupts masked", self.masked),
        ]
        .map(|(what, value)| Figure::new(name(what), value, self.command()))
        .into()
    }
}
