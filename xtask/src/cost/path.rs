//! Instructions of a path of three axes, on the emulated board: `hot_path::path`.

use std::fmt::Write as _;

use serde_json::Value;

use super::figure::Figure;
use crate::emulator::Emulator;
use crate::error::Error;
use crate::thumb::{Builder, Variant};

const PACKAGE: &str = "hot-path";
const COST: &str = "path_cost";
const COMMAND: &str = "cargo xtask cost --only path";

/// Axes of the image.
const AXES: f64 = 3.0;
/// Target for an STM32F405: of one axis in one cycle, planning included.
const INSTRUCTIONS_OF_AN_AXIS: f64 = 400.0;

/// The calls, by the names of their figures in the image.
const CALLS: [(&str, &str); 3] = [
    (
        "PATH_CYCLE",
        "a cycle: preparation, planning, front, average, set-points of three axes",
    ),
    ("PATH_PIECE", "a new line, arc or helix: checked and kept"),
    ("PATH_BOTH", "a cycle that also takes a new piece"),
];

/// What the image has measured.
#[derive(Default)]
pub(crate) struct PathCost {
    /// Largest number of instructions of each of [`CALLS`].
    largest: [f64; CALLS.len()],
}

impl PathCost {
    /// Builds the image and runs it.
    ///
    /// # Errors
    /// When the image does not build, the emulator fails, or a figure is missing.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let arguments = ["--bin", COST].map(str::to_owned);
        builder.build(PACKAGE, &Variant::with_arguments(&arguments))?;
        let figures = emulator.figures(&builder.images().join(COST))?;
        let mut largest = [0.0; CALLS.len()];
        for (largest, (name, _)) in largest.iter_mut().zip(CALLS) {
            *largest = number(&figures[name]["largest"])?;
        }
        Ok(Self { largest })
    }

    /// The section of the document.
    pub(crate) fn write(&self, text: &mut String) {
        text.push_str(SECTION);
        for ((_, what), largest) in CALLS.iter().zip(self.largest) {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {what} | {largest:.0} | {:.0} | `{COMMAND}` |",
                largest / AXES
            );
        }
    }

    /// What is asked for.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let [cycle, _, both] = self.largest;
        [
            ("instructions of one of three axes on a path in one cycle, planning included, worst case", cycle),
            ("the same in a cycle that also takes a new piece", both),
        ]
        .map(|(what, largest)| {
            Figure::new(what, largest / AXES, COMMAND).at_most(INSTRUCTIONS_OF_AN_AXIS)
        })
        .into()
    }

    /// Every figure, for the baseline.
    pub(crate) fn figures(&self) -> Vec<Figure> {
        let calls = CALLS.iter().zip(self.largest);
        calls
            .map(|((_, what), largest)| Figure::new(format!("path: {what}"), largest, COMMAND))
            .chain(self.targets())
            .collect()
    }
}

fn number(value: &Value) -> Result<f64, Error> {
    value.as_f64().ok_or_else(|| Error::Answer {
        program: "the emulator's program `figures`".into(),
        expected: "a largest value of each figure",
    })
}

const SECTION: &str = "\n## A path of three axes

Instructions of the crate `path` for three axes at 1 kHz with a queue of 32 pieces, the worst of 120,000 cycles each (four seeds) of long lines, short lines,
arcs, helices, chords of 20 um, tiny arcs, lines from rest to rest, and all of them mixed, with blended corners, overrides and pauses. A piece is
prepared and planned over several cycles.

| what | largest | of an axis | command |
|---|---|---|---|
";
