//! What an image takes of the RAM, whatever the drives do.

use super::case::{MOST_AXES, TARGET_AXES};
use crate::cost::figure::Figure;
use crate::images::Board;

/// Targets in bytes, for the usual number of axes.
const STACK_IN_MOTION: f64 = 2_048.0;
/// For the largest number of axes.
const STACK_AT_START: f64 = 4_096.0;
const STATIC_RAM: f64 = 8_192.0;

/// What does not depend on the time to answer.
pub(super) struct Memory {
    pub(super) board: Board,
    pub(super) axes: usize,
    pub(super) static_ram: f64,
    pub(super) stack_at_start: f64,
    pub(super) stack_in_motion: f64,
}

pub(super) const COMMAND: &str = "cargo xtask cost --only motion";

impl Memory {
    fn figure(&self, what: &str, value: f64) -> Figure {
        let (board, axes) = (self.board.feature(), self.axes);
        Figure::new(
            format!("{what}, {board}, {axes} axes, bytes"),
            value,
            COMMAND,
        )
    }

    pub(super) fn figures(&self) -> Vec<Figure> {
        vec![
            self.figure("static RAM", self.static_ram),
            self.figure("stack at start", self.stack_at_start),
            self.figure("stack in motion", self.stack_in_motion),
        ]
    }

    pub(super) fn targets(&self) -> Vec<Figure> {
        let [ram, start, motion] = match <[Figure; 3]>::try_from(self.figures()) {
            Ok(figures) => figures,
            Err(_) => return Vec::new(),
        };
        match self.axes {
            TARGET_AXES => vec![motion.at_most(STACK_IN_MOTION)],
            MOST_AXES => vec![ram.at_most(STATIC_RAM), start.at_most(STACK_AT_START)],
            _ => Vec::new(),
        }
    }
}
