//! What the image that takes orders costs: its cycle with a busy link beside that of the image without, and its memory.

use std::fmt::Write as _;

use serde_json::Value;

use super::figure::Figure;
use crate::emulator::Emulator;
use crate::error::Error;
use crate::images::{Board, Image, LINK, LINK_HOMING};
use crate::size::Size;
use crate::thumb::Builder;

/// Numbers of axes at which both images are counted.
const AXES: [usize; 2] = [4, 8];
/// Targets: per cent of the cycle without a link, and bytes of flash.
const MOST_PERCENT: f64 = 110.0;
const MOST_FLASH: f64 = 96.0 * 1024.0;
const COMMAND: &str = "cargo xtask cost --only link";

/// Everything that was measured.
#[derive(Default)]
pub(crate) struct LinkCost {
    cycles: Vec<Cycle>,
    sizes: Vec<Memory>,
}

/// What an image takes of a board.
struct Memory {
    what: String,
    size: Size,
    /// The target holds for it: an image that homes is another one.
    has_target: bool,
    command: String,
}

impl Memory {
    fn measure(
        (builder, emulator): (&Builder, &Emulator),
        board: Board,
        (feature, log): (&str, &str),
    ) -> Result<Self, Error> {
        let image = Image::with_orders(board, feature, log).build(builder, emulator.images())?;
        let has_target = feature == LINK;
        let homing = if has_target { "" } else { " --homing" };
        let board = board.feature();
        Ok(Self {
            what: format!("image with link{homing}, {board}, `DEFMT_LOG={log}`, bytes"),
            size: Size::of_image(&image)?,
            has_target,
            command: format!("DEFMT_LOG={log} cargo fw --link{homing} --board {board}"),
        })
    }

    fn figures(&self) -> [Figure; 2] {
        let (what, command) = (&self.what, &self.command);
        let flash = Figure::new(
            format!("flash of the {what}"),
            self.size.flash() as f64,
            command,
        );
        [
            if self.has_target {
                flash.at_most(MOST_FLASH)
            } else {
                flash
            },
            Figure::new(
                format!("static RAM of the {what}"),
                self.size.ram() as f64,
                command,
            ),
        ]
    }
}

/// Instructions of the handlers of cycle and bus in a millisecond, on average.
struct Cycle {
    board: Board,
    axes: usize,
    with: f64,
    without: f64,
    /// The most in one millisecond.
    worst: [f64; 2],
    /// Of the thread with the link.
    thread: f64,
}

impl Cycle {
    fn read(board: Board, axes: usize, answer: &Value) -> Option<Self> {
        let figure = |image: &str, name: &str| answer[image][name].as_f64();
        Some(Self {
            board,
            axes,
            with: figure("with", "mean")?,
            without: figure("without", "mean")?,
            worst: [figure("with", "worst")?, figure("without", "worst")?],
            thread: figure("with", "thread")?,
        })
    }

    fn figures(&self) -> [Figure; 3] {
        let name = |what: &str| {
            let (board, axes) = (self.board.feature(), self.axes);
            format!("{board}, {axes} axes follow a stream: {what}")
        };
        let percent = 100.0 * self.with / self.without;
        [
            Figure::new(
                name("instructions of the cycle with a busy link"),
                self.with,
                COMMAND,
            ),
            Figure::new(name("worst millisecond of it"), self.worst[0], COMMAND),
            Figure::new(
                name("per cent of the built-in motion without a link"),
                percent,
                COMMAND,
            )
            .at_most(MOST_PERCENT),
        ]
    }
}

impl LinkCost {
    /// Builds the images and counts them.
    ///
    /// # Errors
    /// When an image does not build or the emulator fails.
    pub(crate) fn measure(builder: &Builder, emulator: &Emulator) -> Result<Self, Error> {
        let mut cost = Self::default();
        for board in Board::ALL {
            let with = Image::with_link(board).build(builder, emulator.images())?;
            for image in [(LINK, "info"), (LINK, "off"), (LINK_HOMING, "info")] {
                let memory = Memory::measure((builder, emulator), board, image)?;
                cost.sizes.push(memory);
            }
            for axes in AXES {
                let without = Image::with_axes(board, axes).build(builder, emulator.images())?;
                let answer = emulator.measure_link((&with, &without), board, axes)?;
                let cycle = Cycle::read(board, axes, &answer).ok_or_else(|| Error::Answer {
                    program: "the emulator's program `measure_link`".into(),
                    expected: "figures of both images",
                })?;
                cost.cycles.push(cycle);
            }
        }
        Ok(cost)
    }

    /// Every figure, for the baseline.
    pub(crate) fn figures(&self) -> Vec<Figure> {
        self.targets()
    }

    /// What is asked for.
    pub(crate) fn targets(&self) -> Vec<Figure> {
        let mut figures: Vec<Figure> = self.cycles.iter().flat_map(Cycle::figures).collect();
        figures.extend(self.sizes.iter().flat_map(Memory::figures));
        figures
    }

    /// The section of the document.
    pub(crate) fn write(&self, text: &mut String) {
        text.push_str(SECTION);
        for cycle in &self.cycles {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {:.0} | {:.0} | {:.0} | {} | {} | {:.0} | `{COMMAND}` |",
                cycle.board.feature(),
                cycle.axes,
                cycle.with,
                cycle.without,
                100.0 * cycle.with / cycle.without,
                cycle.worst[0],
                cycle.worst[1],
                cycle.thread
            );
        }
    }
}

const SECTION: &str = "
## The image that takes orders

Instructions of the handlers of cycle and bus in a millisecond. Every axis moves: with the link along curves of fifth degree, 50 segments a second from
a host that looks at its port after up to 20 ms, and 50 snapshots a second; without it along the built-in motion. The thread, which the cycle
interrupts, has the protocol and the checks.

| board | axes | with the link | without | per cent | worst with | worst without | thread | command |
|---|---|---|---|---|---|---|---|---|
";
