//! `cargo xtask proofs`: shows that the libraries cannot panic, what they take of the target, and that the codec stands alone.

use std::path::Path;
use std::process::Command;

use crate::error::Error;
use crate::size::Size;
use crate::symbols::sizes_of_symbols;
use crate::thumb::{Builder, Variant};
use crate::toolchain::Preference;
use crate::workspace::cargo;

/// The package with the images.
const PACKAGE: &str = "proofs";
/// What every image has; its size is taken off the others.
const START_UP: &str = "start-up";
/// The whole codec, unit formulas included; its requests and replies alone; encode a set-point and decode a position.
const CODEC: &str = "codec";
pub(crate) const MESSAGES: &str = "messages";
pub(crate) const HOT_PAIR: &str = "set-point-and-position";
/// Images and what they have without the codec; for the others that is start-up code.
const BESIDE: [(&str, &str); 2] = [
    (MESSAGES, "messages-without-codec"),
    (HOT_PAIR, "set-point-and-position-without-codec"),
];
/// The images that link only without a panic.
const IMAGES: [&str; 21] = [
    CODEC,
    MESSAGES,
    HOT_PAIR,
    "master",
    "family",
    "commissioning",
    "homing",
    "serial",
    SERIAL_STREAM,
    "hub-motors",
    FOUR_HUB_MOTORS,
    "wheels",
    "diff-drive",
    "path",
    "program",
    "trajectory",
    "board-link",
    "board-link-board",
    "board-link-host",
    ONE_AXIS,
    "text",
];
/// Planning and sampling of one axis alone.
pub(crate) const ONE_AXIS: &str = "trajectory-one-axis";
const SERIAL_STREAM: &str = "serial-stream";
const FOUR_HUB_MOTORS: &str = "four-hub-motors";
/// The images that must stay small: what they hold, and their limits in bytes of flash.
const SMALL: [(&str, &str, u64); 3] = [
    (
        SERIAL_STREAM,
        "encode and decode of the serial stream",
        1_024,
    ),
    (
        FOUR_HUB_MOTORS,
        "SDO client, NMT, heartbeat, EMCY and CiA 402 for 4 nodes",
        1_536,
    ),
    (ONE_AXIS, "moves, jogs and stops of one axis", 16 * 1_024),
];
/// The image that must not link.
const DELIBERATE_PANIC: &str = "deliberate-panic";
/// Part of the name of the symbol that the crate panic-never leaves undefined.
const UNDEFINED: &str = "error(panic-never)";
/// The image with statics of the size of masters, and the beginning of their names.
const MEMORY: &str = "memory";
const MASTER_OF: &str = "MASTER_OF_";
/// The crates that need none but [`SHARED`], and the small crates that they share, which need none.
const ALONE: [&str; 6] = [
    "bus-plan",
    "can-frame",
    "dyn-can",
    "dyn-serial",
    "dyn-values",
    "zlac8030l",
];
const SHARED: [&str; 2] = ["can-frame", "dyn-values"];

/// Links the libraries for the target without a panic handler, so that a possible panic is an error, and prints their size.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask proofs                      link, then print sizes\n  \
    cargo xtask proofs --toolchain source   build core from source, as on a machine without rustup's server\n\n\
    When an image does not link, a panic has become possible. `cargo xtask proofs` names the image; make the calls in\n\
    proofs/src fewer until it links again, and the last one taken away is the one that can panic.")]
pub(crate) struct Arguments {
    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// Runs the task.
///
/// # Errors
/// When an image can panic, the one that does panic links, an image is larger than its limit, or a codec has got a dependency.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    builder.build(PACKAGE, &Variant::with_arguments(&["--bins".into()]))?;
    builder.refuse(PACKAGE, DELIBERATE_PANIC, UNDEFINED)?;
    print_flash(&builder.images())?;
    require_small(&builder.images())?;
    print_masters(&builder.images().join(MEMORY))?;
    println!("\n{DELIBERATE_PANIC} does not link, as it must: the images above cannot panic");
    for package in ALONE {
        require_no_dependency(package)?;
        println!("{package} has no dependency but ours");
    }
    Ok(())
}

/// Builds the libraries alone; tells the flash that each takes, start-up code taken off.
///
/// # Errors
/// When one does not build.
pub(crate) fn library_sizes(builder: &Builder) -> Result<Vec<(&'static str, u64)>, Error> {
    builder.build(PACKAGE, &Variant::with_arguments(&["--bins".into()]))?;
    let images = builder.images();
    IMAGES
        .into_iter()
        .map(|image| Ok((image, own_flash(&images, image)?)))
        .collect()
}

fn print_flash(images: &Path) -> Result<(), Error> {
    let start_up = Size::of_image(&images.join(START_UP))?.flash();
    let width = 23;
    println!(
        "{:<width$} {:>9} {:>9}  bytes of flash",
        "image", "all", "its own"
    );
    println!("{START_UP:<width$} {start_up:>9}");
    for image in IMAGES {
        let own = own_flash(images, image)?;
        let all = Size::of_image(&images.join(image))?.flash();
        println!("{image:<width$} {all:>9} {own:>9}");
    }
    Ok(())
}

/// Flash that an image takes beyond the start-up code, and beyond what makes its inputs and uses its results where an image has that
/// alone.
fn own_flash(images: &Path, image: &str) -> Result<u64, Error> {
    let beside = BESIDE.iter().find(|(name, _)| *name == image);
    let beside = beside.map_or(START_UP, |(_, beside)| beside);
    let beside = Size::of_image(&images.join(beside))?.flash();
    let all = Size::of_image(&images.join(image))?.flash();
    Ok(all.saturating_sub(beside))
}

fn require_small(images: &Path) -> Result<(), Error> {
    println!();
    for (image, content, limit) in SMALL {
        let actual = own_flash(images, image)?;
        if actual > limit {
            return Err(Error::TooLarge {
                image,
                limit,
                actual,
            });
        }
        println!("{image} ({content}) takes {actual} of {limit} bytes");
    }
    Ok(())
}

fn print_masters(image: &Path) -> Result<(), Error> {
    println!("\n{:<16} {:>9}  bytes of RAM on the target", "type", "size");
    for (axes, size) in sizes_of_symbols(image, MASTER_OF)? {
        println!("{:<16} {size:>9}", format!("Master<{axes}>"));
    }
    Ok(())
}

/// Asks cargo for the dependencies of a package on every target: there may be none but the shared crates.
fn require_no_dependency(package: &'static str) -> Result<(), Error> {
    let program = format!("cargo tree --package {package}");
    let output = Command::new(cargo())
        .args([
            "tree",
            "--edges",
            "no-dev",
            "--target",
            "all",
            "--prefix",
            "none",
            "--package",
            package,
        ])
        .output()
        .map_err(|reason| Error::Start {
            program: program.clone(),
            reason,
        })?;
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        return Err(Error::Failed {
            program,
            status: output.status,
        });
    }
    match dependencies(&String::from_utf8_lossy(&output.stdout)) {
        none if none.is_empty() => Ok(()),
        found => Err(Error::Dependencies { package, found }),
    }
}

/// All lines of the tree but the package itself and the shared crates.
fn dependencies(tree: &str) -> Vec<String> {
    let is_foreign = |line: &&str| {
        let name = line.split(' ').next().unwrap_or_default();
        !name.is_empty() && !SHARED.contains(&name)
    };
    let lines = tree.lines().skip(1).filter(is_foreign);
    lines.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_but_the_first_and_the_shared_crates_is_a_dependency() {
        let shared = "dyn-can v0.1.0 (/a/dyn-can)\ndyn-values v0.1.0 (/a/dyn-values)\n";
        assert!(dependencies(shared).is_empty());
        assert!(dependencies("dyn-can v0.1.0 (/a/dyn-can)\n").is_empty());
        assert_eq!(
            dependencies("dyn-can v0.1.0 (/a/dyn-can)\nembedded-can v0.4.1\nnb v1.1.0\n"),
            ["embedded-can v0.4.1", "nb v1.1.0"]
        );
    }
}
