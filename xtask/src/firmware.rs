//! `cargo fw`: builds the image of the board.

use std::path::PathBuf;

use crate::error::Error;
use crate::images::{
    Board, COMMISSION, CONFIG, LINK, LINK_HOMING, LINK_USB, PACKAGE, keep_for_board,
};
use crate::output::print;
use crate::size::Size;
use crate::size_profile::SizeProfile;
use crate::thumb::{Builder, Variant};
use crate::toolchain::Preference;

/// Builds the firmware in release for the board's processor and prints its size.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo fw                      build and print the size\n  \
    cargo fw --board stm32g474    the other board\n  \
    cargo fw --toolchain source   build core from source, as on a machine without rustup's server\n  \
    cargo fw --commission         the image that sets the option bytes of a new chip, in the place of the firmware\n  \
    cargo fw --link               the image that takes orders over a serial port\n  \
    cargo fw --link-usb           the same over USB; other pins on the stm32g474, see docs/board.md\n  \
    cargo fw --link --homing      with homing, for axes whose settings ask for it; with --link-usb, too\n  \
    cargo fw --config press.rs    compile this file in the place of src/config.rs\n  \
    cargo fw --symbols            also where the flash goes, by crate and by symbol\n  \
    cargo fw -- --locked          hand further arguments to cargo build\n\n\
    Log lines: the variable DEFMT_LOG (error, warn, info, debug, trace) chooses at build time which are in the image.")]
pub(crate) struct Arguments {
    /// The board
    #[arg(long, value_enum, default_value = "stm32f405")]
    board: Board,

    /// Where the target's core library comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,

    /// The image that sets the brown-out level of a chip, once in its life, instead of the firmware
    #[arg(long, conflicts_with = "config")]
    commission: bool,

    /// The image that takes orders over a serial port; its drives and limits are settings, not src/config.rs
    #[arg(long, group = "orders", conflicts_with_all = ["config", "commission"])]
    link: bool,

    /// The same over USB, as a serial port of the class CDC-ACM; built and linted, its USB never executed
    #[arg(long, group = "orders", conflicts_with_all = ["config", "commission", "link"])]
    link_usb: bool,

    /// With --link or --link-usb: the axes can be homed as their settings say
    #[arg(long, requires = "orders")]
    homing: bool,

    /// Configuration to compile in the place of src/config.rs; it starts with `//` comments, not with `//!`
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// Also print where the flash goes, by crate and by symbol; the lines add up to the size
    #[arg(long)]
    symbols: bool,

    /// Further arguments for `cargo build`
    #[arg(last = true, value_name = "CARGO ARGUMENTS")]
    pub(crate) cargo: Vec<String>,
}

/// Runs the task.
///
/// # Errors
/// When the build fails or leaves no image that could run on the board.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let builder = Builder::find(arguments.toolchain)?;
    let mut variant = Variant::with_arguments(&arguments.board.arguments());
    variant.arguments.extend_from_slice(&arguments.cargo);
    if let Some(config) = &arguments.config {
        variant
            .environment
            .push((CONFIG.into(), config.display().to_string()));
    }
    for (is_chosen, feature) in [
        (arguments.link, LINK),
        (arguments.link_usb, LINK_USB),
        (arguments.homing, LINK_HOMING),
    ] {
        if is_chosen {
            let chosen = ["--features", feature].map(String::from);
            variant.arguments.extend(chosen);
        }
    }
    let name = if arguments.commission {
        let arguments = ["--features", COMMISSION, "--bin", COMMISSION];
        variant.arguments.extend(arguments.map(String::from));
        COMMISSION
    } else {
        PACKAGE
    };
    builder.build(PACKAGE, &variant)?;
    let image = keep_for_board(
        &builder.images().join(name),
        arguments.board,
        builder.target(),
    )?;
    let size = Size::of_image(&image)?;
    println!("{size}\nimage  {}", image.display());
    if arguments.symbols {
        print(format_args!("\n{}", SizeProfile::of_image(&image)?))?;
    }
    Ok(())
}
