//! Instructions and stack of planning and sampling a profile, on the emulated board: `hot_path::trajectory`.

use std::fmt::Write as _;

use serde_json::Value;

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
            let _ = writeln!(text, "| {what} | {mean:.0} | {largest:.0} |");
        }
    }

    /// What is asked for: name, target, actual value.
    pub(crate) fn targets(&self) -> [(&'static str, f64, f64); 3] {
        let [.., (_, sample)] = self.instructions;
        let plans = self.instructions.iter().rev().skip(1);
        let plan = plans.fold(0.0_f64, |most, &(_, largest)| most.max(largest));
        [
            (
                "instructions to plan a profile of one axis, worst case",
                PLAN_INSTRUCTIONS,
                plan,
            ),
            (
                "instructions to sample it, worst case",
                SAMPLE_INSTRUCTIONS,
                sample,
            ),
            (
                "stack of planning, beside the profile, bytes",
                STACK_BYTES,
                self.stack,
            ),
        ]
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

| call | mean | largest |
|---|---|---|
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
        let [(_, _, plan), (_, _, sample), (_, _, stack)] = cost.targets();
        assert_eq!((plan, sample, stack), (40.0, 99.0, 700.0));
        let mut text = String::new();
        cost.write(&mut text);
        assert!(text.contains("| plan a move from any state to rest | 2 | 40 |"));
    }
}
