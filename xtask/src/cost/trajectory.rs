//! Instructions and stack of planning and sampling a profile, on the emulated board: `hot_path::trajectory`.

use std::fmt::Write as _;

use serde_json::Value;

use super::figure::Figure;
use crate::emulator::Emulator;
use crate::error::Error;
use crate::thumb::{Builder, Variant};

const PACKAGE: &str = "hot-path";
const COST: &str = "trajectory_cost";
const STACK: &str = "trajectory_stack";
/// Bytes of a planned profile, which the image for the stack has on its own: the `Result` around it included, see
/// `values_are_small` in the tests of the crate.
const PROFILE: f64 = 360.0;
/// Calls of each kind in the image; `hot_path::trajectory`.
const MOVES: f64 = 2_000.0;
const SAMPLES: f64 = 20_000.0;

const COMMAND: &str = "cargo xtask cost --only trajectory";

/// Targets, for an STM32F405.
const PLAN_INSTRUCTIONS: f64 = 20_000.0;
const SAMPLE_INSTRUCTIONS: f64 = 300.0;
const STACK_BYTES: f64 = 1_024.0;

/// The calls, by the names of their figures in the image.
const CALLS: [(&str, &str, f64); 5] = [
    ("PLAN_AT_REST", "plan a move from rest to rest", MOVES),
    ("PLAN_MOVING", "plan a move from any state to rest", MOVES),
    (
        "PLAN_TRAPEZOID",
        "the same without a limit of the jerk",
        MOVES,
    ),
    ("STOP", "plan a stop from any state", MOVES),
    ("SAMPLE", "the set-point at a time", SAMPLES),
];

/// What the images have measured.
#[derive(Default)]
pub(crate) struct TrajectoryCost {
    /// Mean and largest number of instructions of each of [`CALLS`].
    instructions: [(f64, f64); CALLS.len()],
    /// Bytes of stack, the profile itself not included.
    stack: f64,
}

impl TrajectoryCost {
    /// Builds the images and runs them.
    ///
    /// # Errors
    /// When an image does not build, the emulator fails, or a figure is missing.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let arguments = ["--bin", COST, "--bin", STACK].map(str::to_owned);
        builder.build(PACKAGE, &Variant::with_arguments(&arguments))?;
        let figures = emulator.figures(&builder.images().join(COST))?;
        let stack = emulator.figures(&builder.images().join(STACK))?;
        let mut instructions = [(0.0, 0.0); CALLS.len()];
        for (pair, (name, _, calls)) in instructions.iter_mut().zip(CALLS) {
            let call = &figures[name];
            *pair = (number(&call["sum"])? / calls, number(&call["largest"])?);
        }
        Ok(Self {
            instructions,
            stack: number(&stack["stack"])? - PROFILE,
        })
    }

    /// The section of the document.
    pub(crate) fn write(&self, text: &mut String) {
        text.push_str(SECTION);
        for ((_, what, _), (mean, largest)) in CALLS.iter().zip(self.instructions) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "| {what} | {mean:.0} | {largest:.0} | `{COMMAND}` |");
        }
    }

    /// What is asked for.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let [.., (_, sample)] = self.instructions;
        let plans = self.instructions.iter().rev().skip(1);
        let plan = plans.fold(0.0_f64, |most, &(_, largest)| most.max(largest));
        vec![
            Figure::new(
                "instructions to plan a profile of one axis, worst case",
                plan,
                COMMAND,
            )
            .at_most(PLAN_INSTRUCTIONS),
            Figure::new("instructions to sample it, worst case", sample, COMMAND)
                .at_most(SAMPLE_INSTRUCTIONS),
            Figure::new(
                "stack of planning, beside the profile, bytes",
                self.stack,
                COMMAND,
            )
            .at_most(STACK_BYTES),
        ]
    }

    /// Every figure, for the baseline.
    pub(crate) fn figures(&self) -> Vec<Figure> {
        let calls = CALLS.iter().zip(self.instructions);
        let mut figures: Vec<Figure> = calls
            .flat_map(|((_, what, _), (mean, largest))| {
                [
                    Figure::new(format!("{what}: mean"), mean, COMMAND),
                    Figure::new(format!("{what}: largest"), largest, COMMAND),
                ]
            })
            .collect();
        figures.extend(self.targets());
        figures
    }
}

fn number(value: &Value) -> Result<f64, Error> {
    value.as_f64().ok_or_else(|| Error::Answer {
        program: "the emulator's program `figures`".into(),
        expected: "a sum and a largest value of each figure, and the stack",
    })
}

const SECTION: &str = "
## Profiles of one axis

Instructions of a call of the crate `trajectory`, 2000 random moves: limits over four orders of magnitude, starts inside and beyond
them, distances from one count to millions. Every move is planned in each way, and sampled at ten times.

| call | mean | largest | command |
|---|---|---|---|
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_plan_and_the_worst_sample_count() {
        let cost = TrajectoryCost {
            instructions: [
                (1.0, 10.0),
                (2.0, 40.0),
                (3.0, 30.0),
                (4.0, 20.0),
                (5.0, 99.0),
            ],
            stack: 700.0,
        };
        let values: Vec<f64> = cost.targets().iter().map(|figure| figure.value).collect();
        assert_eq!(values, [40.0, 99.0, 700.0]);
        let mut text = String::new();
        cost.write(&mut text);
        assert!(text.contains("| plan a move from any state to rest | 2 | 40 | `"));
    }
}
