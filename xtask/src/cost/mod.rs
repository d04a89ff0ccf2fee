//! `cargo xtask cost`: what the firmware and the libraries cost on the target, measured, written down and compared.

mod baseline;
mod figure;
mod flash;
mod hot_path;
mod link;
mod motion;
mod path;
mod trajectory;

use std::fmt::Write as _;
use std::fs;

use self::baseline::Baseline;
use self::figure::Figure;
use self::flash::Flash;
use self::hot_path::HotPath;
pub(crate) use self::hot_path::{EIGHT_AXES, FEWER_AXES, ONE_AXIS, PACKAGE as HOT_PATH};
use self::link::LinkCost;
use self::motion::Motion;
use self::path::PathCost;
use self::trajectory::TrajectoryCost;
use crate::emulator::Emulator;
use crate::error::Error;
use crate::output::print;
use crate::thumb::Builder;
use crate::toolchain::Preference;

/// The table, and its figures for a comparison.
const DOCUMENT: &str = "docs/cost.md";
const BASELINE: &str = "docs/cost.json";

/// Measures instructions, stack, flash and RAM and writes docs/cost.md, or compares them with what was written.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask cost                    measure everything, write docs/cost.md and docs/cost.json\n  \
    cargo xtask cost --only hot-path    print the figures of one part, write nothing\n  \
    cargo xtask cost --check            compare what takes a short time with docs/cost.json\n  \
    cargo xtask cost --check --every    compare every figure\n\n\
    --check fails when a figure has risen by more than 3 %. A rise that is meant is accepted by `cargo xtask cost`, which writes\n\
    both files anew; the commit says what it bought. Figures of another compiler are not compared.\n\
    Instructions are counted on the emulated board: a measure to compare by, not microseconds.")]
pub(crate) struct Arguments {
    /// Measure one part and print it
    #[arg(long, value_enum, conflicts_with = "check")]
    only: Option<Part>,

    /// Compare with docs/cost.json and fail on a rise of more than 3 %
    #[arg(long)]
    check: bool,

    /// Compare every figure, not only those that take a short time
    #[arg(long, requires = "check")]
    every: bool,

    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// What can be measured by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// The firmware with its axes standing and moving, and its memory.
    Motion,
    /// Encoding, decoding, and an axis of the master alone.
    HotPath,
    /// Planning and sampling of profiles.
    Trajectory,
    /// Paths of three axes.
    Path,
    /// Flash of images and libraries.
    Flash,
    /// The cycle with a busy link.
    Link,
}

/// Runs the task.
///
/// # Errors
/// When something does not build, the emulator fails, a file cannot be written, or a figure has risen.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let tools = Tools::find(arguments.toolchain)?;
    if arguments.check {
        let unchecked = tools.check(arguments.every)?;
        return unchecked
            .iter()
            .try_for_each(|reason| print(format_args!("{reason}\n")));
    }
    match arguments.only {
        Some(part) => print(lines(&tools.part(part)?)),
        None => tools.write(),
    }
}

/// Compares the figures that take a short time with those of the table; tells what could not be compared.
///
/// # Errors
/// When something does not build, the emulator fails, or a figure has risen.
pub(crate) fn check() -> Result<Vec<String>, Error> {
    Tools::find(Preference::Auto)?.check(false)
}

/// What measures.
struct Tools {
    builder: Builder,
    emulator: Emulator,
}

impl Tools {
    fn find(preference: Preference) -> Result<Self, Error> {
        Ok(Self {
            builder: Builder::find(preference)?,
            emulator: Emulator::prepare()?,
        })
    }

    fn part(&self, part: Part) -> Result<Vec<Figure>, Error> {
        let Self { builder, emulator } = self;
        Ok(match part {
            Part::Motion => Motion::measure(builder, emulator)?.figures(),
            Part::HotPath => HotPath::measure(builder, emulator)?.targets(),
            Part::Trajectory => TrajectoryCost::measure(builder, emulator)?.figures(),
            Part::Path => PathCost::measure(builder, emulator)?.figures(),
            Part::Flash => Flash::measure(builder, emulator.images())?.figures(),
            Part::Link => LinkCost::measure(builder, emulator)?.targets(),
        })
    }

    fn everything(&self) -> Result<Cost, Error> {
        let Self { builder, emulator } = self;
        Ok(Cost {
            flash: Flash::measure(builder, emulator.images())?,
            motion: Motion::measure(builder, emulator)?,
            hot_path: HotPath::measure(builder, emulator)?,
            trajectory: TrajectoryCost::measure(builder, emulator)?,
            path: PathCost::measure(builder, emulator)?,
            link: LinkCost::measure(builder, emulator)?,
        })
    }

    fn few(&self) -> Result<Cost, Error> {
        let Self { builder, emulator } = self;
        Ok(Cost {
            flash: Flash::measure_few(builder, emulator.images())?,
            motion: Motion::measure_few(builder, emulator)?,
            hot_path: HotPath::measure(builder, emulator)?,
            trajectory: TrajectoryCost::measure(builder, emulator)?,
            path: PathCost::measure(builder, emulator)?,
            link: LinkCost::default(),
        })
    }

    fn write(&self) -> Result<(), Error> {
        let cost = self.everything()?;
        let compiler = self.builder.compiler();
        let mut document = cost.document(&compiler);
        document += &cost.motion.profile(&self.builder, &self.emulator)?;
        let path = self.builder.root().join(DOCUMENT);
        fs::write(&path, &document).map_err(|reason| Error::Image {
            path,
            reason: reason.to_string(),
        })?;
        Baseline::new(compiler, &cost.figures()).write(&self.builder.root().join(BASELINE))?;
        print(document)
    }

    fn check(&self, every: bool) -> Result<Vec<String>, Error> {
        let baseline = Baseline::read(&self.builder.root().join(BASELINE))?;
        let compiler = self.builder.compiler();
        if compiler != baseline.compiler {
            return Ok(vec![format!(
                "{BASELINE} belongs to {}, and this is {compiler}: not compared",
                baseline.compiler
            )]);
        }
        let cost = if every {
            self.everything()?
        } else {
            self.few()?
        };
        let changes = baseline.compare(&cost.figures());
        print(&changes)?;
        if changes.risen.is_empty() {
            return Ok(Vec::new());
        }
        Err(Error::Risen {
            figures: changes.risen.len(),
        })
    }
}

/// Everything that was measured.
struct Cost {
    flash: Flash,
    motion: Motion,
    hot_path: HotPath,
    trajectory: TrajectoryCost,
    path: PathCost,
    link: LinkCost,
}

impl Cost {
    /// Every figure, for the baseline.
    fn figures(&self) -> Vec<Figure> {
        [
            self.motion.figures(),
            self.hot_path.targets(),
            self.trajectory.figures(),
            self.path.figures(),
            self.flash.figures(),
            self.link.figures(),
        ]
        .concat()
    }

    fn document(&self, compiler: &str) -> String {
        let mut text = format!("{INTRODUCTION}\nCompiler: {compiler}.\n");
        self.write_targets(&mut text);
        self.motion.write(&mut text);
        self.trajectory.write(&mut text);
        self.path.write(&mut text);
        self.flash.write(&mut text);
        self.link.write(&mut text);
        text
    }

    fn write_targets(&self, text: &mut String) {
        text.push_str(TARGETS);
        let targets = [
            self.motion.targets(),
            self.hot_path.targets(),
            self.trajectory.targets(),
            self.path.targets(),
            self.flash.targets(),
            self.link.targets(),
        ];
        for figure in targets.concat() {
            let Figure {
                name,
                value,
                command,
                ..
            } = &figure;
            let target = figure
                .target
                .map(|target| target.to_string())
                .unwrap_or_default();
            let verdict = figure.verdict().unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {name} | {target} | {value:.0} | {verdict} | `{command}` |"
            );
        }
    }
}

/// One figure a line.
fn lines(figures: &[Figure]) -> String {
    figures.iter().fold(String::new(), |mut text, figure| {
        let verdict = figure
            .verdict()
            .map_or(String::new(), |verdict| format!("  {verdict}"));
        let _ = writeln!(text, "{:>10}  {}{verdict}", figure.value, figure.name);
        text
    })
}

const INTRODUCTION: &str = "# What it costs

Made by `cargo xtask cost`; do not edit. Instructions are counted on the emulated boards (see `firmware-tests/README.md`): a
measure to compare by, not microseconds. Wait states of the flash are not modelled, nor instructions that take more than one clock: on silicon the
same work takes longer. At 168 MHz a cycle of 1 ms has 168,000 clocks. Each row names the command that prints its figure. `cargo xtask cost --check`
compares with `docs/cost.json`, which has every figure, and fails when one has risen by more than 3 %.
";
const TARGETS: &str = "
## Targets

1 kHz; \"worst of all drives\" is the worst of the rows of that board below, drives that answer after 100 to 1500 us, standing and moving.

| figure | target | actual | | command |
|---|---|---|---|---|
";
