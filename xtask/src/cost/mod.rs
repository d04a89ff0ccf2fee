//! `cargo xtask cost`: what the firmware and the libraries cost on the target, measured and written to docs/cost.md.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::emulator::Emulator;
use crate::error::Error;
use crate::hot_path::HotPath;
use crate::images::{Board, Image};
use crate::proofs;
use crate::size::Size;
use crate::thumb::Builder;
use crate::toolchain::Preference;
use crate::trajectory_cost::TrajectoryCost;

/// Numbers of axes that are measured in motion.
const AXES: [usize; 4] = [1, 4, 8, 14];
/// The one for which the targets are given.
const TARGET_AXES: usize = 8;
const DOCUMENT: &str = "docs/cost.md";

/// Targets, for an STM32F405 at 168 MHz and 1 kHz.
const CYCLE_INSTRUCTIONS: f64 = 5_000.0;
const FLASH_WITH_LOG: u64 = 48 * 1024;
const FLASH_WITHOUT_LOG: u64 = 32 * 1024;
const AXIS_INSTRUCTIONS: f64 = 60.0;
const ENCODE_INSTRUCTIONS: f64 = 25.0;
const DECODE_INSTRUCTIONS: f64 = 18.0;
const RAM_14_AXES: u64 = 8 * 1024;
const STACK: u64 = 2 * 1024;
const MASKED_INSTRUCTIONS: f64 = 350.0;
const MESSAGES_FLASH: u64 = 4 * 1024;
const HOT_PAIR_FLASH: u64 = 256;
const ONE_AXIS_FLASH: u64 = 16 * 1024;

/// Measures instructions, stack, flash and RAM, and writes docs/cost.md.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  \
    cargo xtask cost    build the images, run them on the emulated board, write docs/cost.md\n\n\
    Instructions are counted on the emulated board: a measure to compare by, not microseconds.")]
pub(crate) struct Arguments {
    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// Runs the task.
///
/// # Errors
/// When something does not build, the emulator fails, or the document cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let emulator = Emulator::prepare()?;
    let cost = Cost {
        images: image_sizes(&builder, emulator.images())?,
        motion: motion(&builder, &emulator)?,
        hot_path: HotPath::measure(&builder, &emulator)?,
        trajectory: TrajectoryCost::measure(&builder, &emulator)?,
        libraries: proofs::library_sizes(&builder)?,
    };
    let document = cost.document();
    print!("{document}");
    let path = builder.root().join(DOCUMENT);
    fs::write(&path, document).map_err(|reason| Error::Image {
        path,
        reason: reason.to_string(),
    })
}

/// Everything that was measured.
struct Cost {
    images: Vec<ImageSize>,
    motion: Vec<Motion>,
    hot_path: HotPath,
    trajectory: TrajectoryCost,
    libraries: Vec<(&'static str, u64)>,
}

/// Size of one image.
struct ImageSize {
    what: String,
    flash: u64,
    ram: u64,
    target: Option<u64>,
}

/// One image in motion.
struct Motion {
    axes: usize,
    ram: u64,
    figures: Value,
}

impl Motion {
    fn figure(&self, name: &str) -> f64 {
        self.figures[name].as_f64().unwrap_or(f64::NAN)
    }
}

fn image_sizes(builder: &Builder, folder: &Path) -> Result<Vec<ImageSize>, Error> {
    let mut sizes = Vec::new();
    for (log, target) in [("info", FLASH_WITH_LOG), ("off", FLASH_WITHOUT_LOG)] {
        for board in Board::ALL {
            let image = Image::of_board(board, log).build(builder, folder)?;
            let size = Size::of_image(&image)?;
            sizes.push(ImageSize {
                what: format!("{}, 2 axes, `DEFMT_LOG={log}`", board.feature()),
                flash: size.flash(),
                ram: size.ram(),
                target: (board == Board::Stm32f405).then_some(target),
            });
        }
    }
    Ok(sizes)
}

fn motion(builder: &Builder, emulator: &Emulator) -> Result<Vec<Motion>, Error> {
    let measure = |axes: usize| {
        let image = Image::with_axes(axes).build(builder, emulator.images())?;
        Ok(Motion {
            axes,
            ram: Size::of_image(&image)?.ram(),
            figures: emulator.measure(&image, axes)?,
        })
    };
    AXES.into_iter().map(measure).collect()
}

impl Cost {
    fn document(&self) -> String {
        let mut text = String::from(INTRODUCTION);
        self.write_motion(&mut text);
        self.trajectory.write(&mut text);
        self.write_sizes(&mut text);
        self.write_targets(&mut text);
        text.push_str(WHERE);
        text
    }

    fn write_motion(&self, text: &mut String) {
        text.push_str(MOTION);
        for motion in &self.motion {
            let rounded = |name| motion.figure(name).round();
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                motion.axes,
                rounded("all"),
                rounded("worst"),
                rounded("cycle"),
                rounded("transmit"),
                rounded("receive"),
                rounded("timer"),
                rounded("thread"),
                rounded("masked"),
                rounded("stack_in_motion"),
                rounded("stack_at_start"),
                motion.ram
            );
        }
        if let [.., fewer, more] = &self.motion[..3] {
            let each = (more.figure("all") - fewer.figure("all")) / (more.axes - fewer.axes) as f64;
            let _ = writeln!(
                text,
                "\nOne axis more costs {each:.0} instructions a cycle, everything included ({} to {} axes).",
                fewer.axes, more.axes
            );
        }
    }

    fn write_sizes(&self, text: &mut String) {
        text.push_str(SIZES);
        for ImageSize {
            what, flash, ram, ..
        } in &self.images
        {
            let _ = writeln!(text, "| {what} | {flash} | {ram} |");
        }
        for (what, flash) in &self.libraries {
            let _ = writeln!(text, "| {what} | {flash} | |");
        }
    }

    fn write_targets(&self, text: &mut String) {
        text.push_str(TARGETS);
        let mut row = |what: &str, target: f64, actual: f64| {
            let verdict = if actual <= target {
                "met".to_owned()
            } else {
                format!("missed, {:.1} times the target", actual / target)
            };
            let _ = writeln!(text, "| {what} | {target:.0} | {actual:.0} | {verdict} |");
        };
        for (what, target, actual) in [
            (
                "instructions of one axis in one cycle, master alone: target in, frame out",
                AXIS_INSTRUCTIONS,
                self.hot_path.axis,
            ),
            (
                "instructions to encode a set-point",
                ENCODE_INSTRUCTIONS,
                self.hot_path.encode,
            ),
            (
                "instructions to decode a position reply",
                DECODE_INSTRUCTIONS,
                self.hot_path.decode,
            ),
        ] {
            row(what, target, actual);
        }
        for (what, target, actual) in self.trajectory.targets() {
            row(what, target, actual);
        }
        for motion in &self.motion {
            if motion.axes == TARGET_AXES {
                row(
                    "instructions of a cycle, 8 axes",
                    CYCLE_INSTRUCTIONS,
                    motion.figure("all"),
                );
                row(
                    "longest stretch with interrupts masked, 8 axes, instructions",
                    MASKED_INSTRUCTIONS,
                    motion.figure("masked"),
                );
                row(
                    "stack in motion, 8 axes, bytes",
                    STACK as f64,
                    motion.figure("stack_in_motion"),
                );
            }
            if motion.axes == 14 {
                row(
                    "static RAM, 14 axes, bytes",
                    RAM_14_AXES as f64,
                    motion.ram as f64,
                );
            }
        }
        for image in &self.images {
            if let Some(target) = image.target {
                row(
                    &format!("flash, {}, bytes", image.what),
                    target as f64,
                    image.flash as f64,
                );
            }
        }
        for (what, flash) in &self.libraries {
            match *what {
                proofs::MESSAGES => row(
                    "flash of dyn-can, every request and reply, bytes",
                    MESSAGES_FLASH as f64,
                    *flash as f64,
                ),
                proofs::HOT_PAIR => row(
                    "flash of one set-point encoded and one position decoded, bytes",
                    HOT_PAIR_FLASH as f64,
                    *flash as f64,
                ),
                proofs::ONE_AXIS => row(
                    "flash of moves, jogs and stops of one axis, bytes",
                    ONE_AXIS_FLASH as f64,
                    *flash as f64,
                ),
                _ => {}
            }
        }
    }
}

const INTRODUCTION: &str = "# What it costs

Made by `cargo xtask cost`; do not edit. Instructions are counted on the emulated board (see `firmware-tests/README.md`): a
measure to compare by, not microseconds: the emulated flash has no wait states. At 168 MHz a cycle of 1 ms has 168,000 clocks.
";
const MOTION: &str = "
## In motion

Instructions of one cycle of 1 ms, every axis streaming, status and position of every axis at 50 Hz (14 axes: no polls, the
bus is full). Mean over two seconds; \"worst\" is the worst millisecond, a line of the log included. \"Cycle\" is the task of the
cycle with everything that it does when frames come and go; the others are interrupts and the thread. \"Masked\" is the longest stretch
with interrupts masked.

| axes | all | worst | cycle | transmit | receive | timer | thread | masked | stack in motion | stack at start | static RAM |
|---|---|---|---|---|---|---|---|---|---|---|---|
";
const SIZES: &str = "
## Flash and RAM

Bytes. Libraries alone, every public call reachable, start-up code taken off (`cargo xtask proofs`).

| image | flash | RAM |
|---|---|---|
";
const TARGETS: &str = "
## Targets

| figure (STM32F405, 1 kHz) | target | actual | |
|---|---|---|---|
";
const WHERE: &str = "
## Where it goes

Instructions: the master looks through all its axes for the request of a cycle and for its place among the set-points, and the
application looks at all of them once more. Each frame that has gone out while another waits for room wakes the task of the cycle; a refill
from the transmit interrupt itself would take that away.

Flash: about half of the image without a log is the master, compiled for speed into the task of the cycle and the service of the bus;
compiled for size the image is 8 KiB smaller and a cycle takes 1.4 times the instructions. The log lines are the difference between
`info` and `off`. A master that is made for a plan of a `const` has no analysis of the bus in it; the library image `master` has both.
`text` is every message in words.

RAM: the master has about 600 bytes an axis and 2 KiB for 64 events that nobody has read yet. The stack is only deep while the master
is built on it, before anything moves.
";

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn cost(instructions: f64) -> Cost {
        let motion = |axes| Motion {
            axes,
            ram: 9_000,
            figures: json!({"all": instructions, "stack_in_motion": 1_000, "masked": 140}),
        };
        Cost {
            images: Vec::new(),
            motion: AXES.map(motion).into(),
            hot_path: HotPath {
                encode: 20.0,
                decode: 20.0,
                axis: 20.0,
            },
            trajectory: TrajectoryCost::default(),
            libraries: Vec::new(),
        }
    }

    #[test]
    fn a_target_that_is_missed_says_by_how_much() {
        let text = cost(7_500.0).document();
        assert!(text.contains(
            "| instructions of a cycle, 8 axes | 5000 | 7500 | missed, 1.5 times the target |"
        ));
        assert!(text.contains("| stack in motion, 8 axes, bytes | 2048 | 1000 | met |"));
    }
}
