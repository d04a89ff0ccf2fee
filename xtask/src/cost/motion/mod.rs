//! What a cycle of the firmware takes on both boards, by number of axes and by the time that the drives take to answer.

mod case;
mod memory;

use std::fmt::Write as _;

use serde_json::Value;

use self::case::{Case, MOST_AXES, TARGET_AXES};
use self::memory::Memory;
use super::figure::Figure;
use crate::emulator::{AxisMotion, Emulator, Load};
use crate::error::Error;
use crate::images::{Board, Image};
use crate::profile;
use crate::size::Size;
use crate::thumb::Builder;

/// Times until a drive answers; with a quarter more or less they leave no gap.
const RESPONSES_US: [u32; 10] = [100, 200, 300, 400, 500, 650, 800, 1_000, 1_250, 1_500];
/// The other numbers of axes, at one time.
const OTHER_AXES: [usize; 3] = [1, 4, MOST_AXES];
const OTHER_RESPONSE_US: u32 = 500;
/// What is compared with the baseline in a short time.
const FEW: Cases = Cases {
    board: Board::Stm32f405,
    axes: TARGET_AXES,
    responses_us: &RESPONSES_US,
};

/// Targets, for 8 axes and a cycle of 1 ms.
const MEAN_INSTRUCTIONS: f64 = 5_000.0;
const WORST_INSTRUCTIONS: f64 = 8_000.0;
const MASKED_INSTRUCTIONS: f64 = 350.0;

/// One image and the times at which it is measured.
#[derive(Clone, Copy)]
struct Cases {
    board: Board,
    axes: usize,
    responses_us: &'static [u32],
}

/// Everything that was measured.
pub(crate) struct Motion {
    cases: Vec<Case>,
    memory: Vec<Memory>,
}

impl Motion {
    /// Builds every image and measures it in every case.
    ///
    /// # Errors
    /// When an image does not build or the emulator fails.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let mut all = Vec::new();
        for board in Board::ALL {
            for axes in OTHER_AXES.into_iter().chain([TARGET_AXES]) {
                let responses_us: &[u32] = if axes == TARGET_AXES {
                    &RESPONSES_US
                } else {
                    &[OTHER_RESPONSE_US]
                };
                all.push(Cases {
                    board,
                    axes,
                    responses_us,
                });
            }
        }
        Self::of(&all, builder, emulator)
    }

    /// The same for the image of the default board with 8 axes, to compare it in a short time.
    ///
    /// # Errors
    /// When the image does not build or the emulator fails.
    pub(crate) fn measure_few(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        Self::of(&[FEW], builder, emulator)
    }

    fn of(all: &[Cases], builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let mut motion = Self {
            cases: Vec::new(),
            memory: Vec::new(),
        };
        for cases in all {
            let Cases {
                board,
                axes,
                responses_us,
            } = *cases;
            let image = Image::with_axes(board, axes).build(builder, emulator.images())?;
            let static_ram = Size::of_image(&image)?.ram() as f64;
            let answer = emulator.measure(&image, board, axes, responses_us)?;
            motion
                .add(cases, static_ram, &answer)
                .ok_or_else(|| Error::Answer {
                    program: "the emulator's program `measure`".into(),
                    expected: "figures of standing and moving axes for each time",
                })?;
        }
        Ok(motion)
    }

    fn add(&mut self, cases: &Cases, static_ram: f64, answer: &Value) -> Option<()> {
        let Cases { board, axes, .. } = *cases;
        let measured = answer.as_array()?;
        let largest = |name: &str| {
            let mut each = measured.iter().map(|figures| figures[name].as_f64());
            each.try_fold(0.0_f64, |most, value| Some(most.max(value?)))
        };
        self.memory.push(Memory {
            board,
            axes,
            static_ram,
            stack_at_start: largest("stack_at_start")?,
            stack_in_motion: largest("stack_in_motion")?,
        });
        for (figures, &response_us) in measured.iter().zip(cases.responses_us) {
            for motion in [AxisMotion::Standing, AxisMotion::BuiltIn] {
                let load = Load {
                    axes,
                    response_us,
                    motion,
                };
                let figures = &figures[motion.to_string()];
                self.cases.push(Case::read(board, load, figures)?);
            }
        }
        Some(())
    }

    /// Every figure, for the baseline.
    pub(crate) fn figures(&self) -> Vec<Figure> {
        let cases = self.cases.iter().flat_map(Case::figures);
        cases
            .chain(self.memory.iter().flat_map(Memory::figures))
            .collect()
    }

    /// What is asked for: the worst of all cases of 8 axes, and the memory.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let mut targets = Vec::new();
        for board in Board::ALL {
            let eight = || {
                let cases = self.cases.iter();
                cases.filter(move |case| case.board == board && case.load.axes == TARGET_AXES)
            };
            for (what, of, target) in [
                (
                    "mean",
                    (|case| case.mean) as fn(&Case) -> f64,
                    MEAN_INSTRUCTIONS,
                ),
                ("worst millisecond", |case| case.worst, WORST_INSTRUCTIONS),
                (
                    "longest stretch with interrupts masked",
                    |case| case.masked,
                    MASKED_INSTRUCTIONS,
                ),
            ] {
                let Some(worst) = eight().max_by(|one, other| of(one).total_cmp(&of(other))) else {
                    continue;
                };
                let name = format!(
                    "instructions of a cycle, {}, {TARGET_AXES} axes, worst of all drives: {what}",
                    board.feature()
                );
                targets.push(Figure::new(name, of(worst), worst.command()).at_most(target));
            }
        }
        targets.extend(self.memory.iter().flat_map(Memory::targets));
        targets
    }

    /// The section of the document.
    pub(crate) fn write(&self, text: &mut String) {
        text.push_str(SECTION);
        for case in &self.cases {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {:.0} | {} | {} | {} | `{}` |",
                case.board.feature(),
                case.load.axes,
                case.load.response_us,
                case.load.motion,
                case.mean,
                case.worst,
                case.worst_without_line,
                case.masked,
                case.command()
            );
        }
        self.write_contexts(text);
        text.push_str(MEMORY);
        for memory in &self.memory {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | `{}` |",
                memory.board.feature(),
                memory.axes,
                memory.static_ram,
                memory.stack_at_start,
                memory.stack_in_motion,
                memory::COMMAND
            );
        }
    }

    /// The case of 8 axes with the largest mean.
    fn dearest(&self, board: Board) -> Option<&Case> {
        let cases = self.cases.iter();
        let eight = cases.filter(|case| case.board == board && case.load.axes == TARGET_AXES);
        eight.max_by(|one, other| one.mean.total_cmp(&other.mean))
    }

    /// Where the dearest cycle of the default board goes, by function.
    ///
    /// # Errors
    /// When the image does not build or the emulator fails.
    pub(crate) fn profile(&self, builder: &Builder, emulator: &Emulator) -> Result<String, Error> {
        let Some(Case { board, load, .. }) = self.dearest(Board::Stm32f405) else {
            return Ok(String::new());
        };
        let image = Image::with_axes(*board, load.axes).build(builder, emulator.images())?;
        let table = profile::table(emulator, &image, *board, *load)?;
        Ok(format!(
            "{PROFILE}{}: {load}\n{table}```\n",
            board.feature()
        ))
    }

    /// Where the cycle of the dearest case of each board goes, by context.
    fn write_contexts(&self, text: &mut String) {
        text.push_str(CONTEXTS);
        for board in Board::ALL {
            let Some(worst) = self.dearest(board) else {
                continue;
            };
            let contexts: Vec<String> = worst
                .contexts
                .iter()
                .map(|(name, instructions)| format!("{name} {instructions:.0}"))
                .collect();
            let _ = writeln!(
                text,
                "- {}, {}: {}",
                board.feature(),
                worst.load,
                contexts.join(", ")
            );
        }
    }
}

const SECTION: &str = "
## In motion

Instructions of one cycle of 1 ms, every axis streaming, status and position of every axis at 50 Hz (14 axes: no polls, the
bus is full). Each reply comes after the time of the row, up to a quarter more or less, drawn anew for each. Counted over two
seconds; a line of the log is written in each, and \"no line\" is the worst millisecond without one. \"Masked\" is the longest stretch
with interrupts masked.

| board | axes | drives answer after, us | axes are | mean | worst ms | no line | masked | command |
|---|---|---|---|---|---|---|---|---|
";
const CONTEXTS: &str = "
Instructions of a cycle by context, the dearest mean of 8 axes: interrupts by their names in the vector table (UART5, which has no other
use, runs the cycle), and the thread.

";
const MEMORY: &str = "
Bytes, the deepest of all cases:

| board | axes | static RAM | stack at start | stack in motion | command |
|---|---|---|---|---|---|
";

const PROFILE: &str = "
## Where it goes

The row above with the largest mean; the command of the row prints more. An instruction counts for the innermost function that it
belongs to, also where that is inlined, and the standard library for its caller.

```text
";

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn measured(standing: u32, moving: u32) -> Value {
        let figures = |mean: u32| {
            json!({"mean": mean, "worst": 2 * mean, "worst_without_line": mean + 1, "masked": 140,
                "contexts": {"thread": 10, "UART5": mean - 10}})
        };
        json!({"standing": figures(standing), "moving": figures(moving),
            "stack_at_start": 7_000, "stack_in_motion": 1_000})
    }

    fn motion() -> Motion {
        let mut motion = Motion {
            cases: Vec::new(),
            memory: Vec::new(),
        };
        let cases = Cases {
            board: Board::Stm32f405,
            axes: TARGET_AXES,
            responses_us: &[100, 500],
        };
        let answer = json!([measured(3_000, 4_000), measured(6_000, 5_000)]);
        motion.add(&cases, 9_000.0, &answer).unwrap();
        motion
    }

    #[test]
    fn the_target_is_held_against_the_worst_case_and_names_its_command() {
        let targets = motion().targets();
        let mean = &targets[0];
        assert_eq!(
            (mean.value, mean.target),
            (6_000.0, Some(MEAN_INSTRUCTIONS))
        );
        assert_eq!(
            mean.command,
            "cargo xtask profile --axes 8 --board stm32f405 --response-us 500"
        );
        assert_eq!(targets[1].value, 12_000.0);
    }

    #[test]
    fn every_case_has_a_row_and_figures_of_its_own() {
        let mut text = String::new();
        motion().write(&mut text);
        assert!(text.contains("| stm32f405 | 8 | 100 | moving | 4000 | 8000 | 4001 | 140 | `cargo xtask profile --axes 8 --board stm32f405 --response-us 100 --moving` |"), "{text}");
        assert!(text.contains("UART5 5990, thread 10"), "{text}");
        let figures = motion().figures();
        assert_eq!(figures.len(), 4 * 4 + 3);
        let mut names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), figures.len());
    }
}
