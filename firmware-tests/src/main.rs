//! Runs an image on the emulated board, with the contacts closed one after the other as an operator would, and prints its log.
// Nothing of it is a test, and the tests of the pseudo-terminal belong to `motionctl`.
#![cfg(not(test))]

#[cfg(unix)]
mod link_terminal;
mod mechanics;
#[cfg(unix)]
#[path = "../../crates/motionctl/src/system/unix/pseudo_terminal.rs"]
mod pseudo_terminal;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use drive_sim::{DynDriveConfig, ZlacDriveConfig};
use dyn_can::GearNumber;
use firmware_tests::rig::MS;
use firmware_tests::{Contact, Image, Rig, Stop};
use mechanics::MechanicsOptions;
use zlac8030l::NodeId;

/// When each contact is closed.
const OPERATOR: [(u64, Contact); 3] = [
    (100, Contact::Stop),
    (500, Contact::Enable),
    (1_500, Contact::Run),
];

/// Runs an image of the firmware on an emulated board, that of the variable FIRMWARE_BOARD, with simulated drives 1, 2, 3, ... and prints its log.
#[derive(Parser)]
#[command(
    name = "emulate",
    after_help = "The stop circuit is closed after 0.1 s, enable after 0.5 s, run after 1.5 s.\n\n\
    Examples:\n  cargo xtask emulate --config my-machine.rs -- --drives 5,6:8192,9 --ms 4000\n  \
    cargo xtask emulate --config firmware-tests/configs/hub_motors.rs -- --hub-motors 1,2\n  \
    cargo xtask emulate --link /tmp/board -- --drives 1,2,3,4 --settings machine.toml\n  \
    cargo xtask emulate --link /tmp/board --homing -- --drives 1,2 --stops=-2:3 --switch 2:1.5 --settings machine.toml"
)]
struct Arguments {
    /// The image
    image: PathBuf,
    /// Ids of the drives on the bus, each with its gear number behind a colon when that is not 4096
    #[arg(long, value_delimiter = ',', default_value = "1,2", value_parser = parse_drive)]
    drives: Vec<(u8, DynDriveConfig)>,
    /// Nodes of ZLAC8030L hub motors on a bus of 500 kbit/s, in place of the servo drives
    #[arg(long, value_delimiter = ',', conflicts_with = "drives", value_parser = parse_hub_motor)]
    hub_motors: Vec<ZlacDriveConfig>,
    #[command(flatten)]
    mechanics: MechanicsOptions,
    /// Milliseconds to run; with --link for ever when it is not said
    #[arg(long)]
    ms: Option<u64>,
    /// Run in real time, with the serial port of the board on a pseudo-terminal under this name; the image must be one that takes orders
    #[cfg(unix)]
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// With --link: settings that are written to the board before, a TOML file as `motionctl board settings` has it
    #[cfg(unix)]
    #[arg(long, value_name = "FILE", requires = "link")]
    settings: Option<PathBuf>,
}

/// How long it runs without --link.
const USUAL_MS: u64 = 4_000;

/// `5` or `5:8192`.
fn parse_drive(text: &str) -> Result<(u8, DynDriveConfig), String> {
    let (id, gear) = text.split_once(':').unwrap_or((text, "4096"));
    let number = |text: &str| {
        text.parse::<i32>()
            .map_err(|error| format!("{text}: {error}"))
    };
    let id = number(id)?;
    let mut drive = DynDriveConfig::numbered(id).map_err(|error| error.to_string())?;
    drive.group3.gear_number = GearNumber::new(number(gear)?).map_err(|error| error.to_string())?;
    // It has been checked: 1 to 63.
    Ok((id as u8, drive))
}

fn parse_hub_motor(text: &str) -> Result<ZlacDriveConfig, String> {
    let node = text.parse::<i32>();
    let node = node.map_err(|error| format!("{text}: {error}"))?;
    let node = NodeId::new(node).map_err(|error| error.to_string())?;
    Ok(ZlacDriveConfig::new(node))
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let image = match Image::read(&arguments.image) {
        Ok(image) => image,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    let mut rig = if arguments.hub_motors.is_empty() {
        let mechanics = &arguments.mechanics;
        let drives = arguments.drives.into_iter();
        Rig::with_drives(image, drives.map(|(id, drive)| mechanics.on(id, drive)))
    } else {
        Rig::with_hub_motors(image, arguments.hub_motors)
    };
    #[cfg(unix)]
    if let Some(link) = &arguments.link {
        let written = arguments.settings.as_deref().map_or(Ok(()), |settings| {
            link_terminal::write_settings(&mut rig, settings)
        });
        let ran = written.and_then(|()| {
            link_terminal::run(&mut rig, link, (arguments.ms, &arguments.mechanics))
        });
        return match ran {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    let (mut printed, end_ms) = (0, arguments.ms.unwrap_or(USUAL_MS));
    for ms in 0..end_ms {
        for (_, contact) in OPERATOR.iter().filter(|(at_ms, _)| *at_ms == ms) {
            println!("--- {contact:?} is closed");
            rig.close(*contact);
        }
        arguments.mechanics.connect(&mut rig);
        let stop = rig.run_ms(1);
        for line in &rig.board().log()[printed..] {
            println!("{line}");
        }
        printed = rig.board().log().len();
        if stop != Stop::Limit {
            eprintln!("error: the processor stopped: {stop:x?}");
            return ExitCode::FAILURE;
        }
    }
    print_end(&rig, end_ms);
    ExitCode::SUCCESS
}

fn print_end(rig: &Rig, ms: u64) {
    println!("--- after {ms} ms");
    let now_ns = ms * MS;
    for drive in rig.servos() {
        println!(
            "drive {:>2}: {:>8} set-points, {:>8} counts commanded, now at {:>8}, {}",
            drive.id().map_or(0, |id| id.get()),
            drive.books().pd_frames,
            drive.commanded_counts(),
            drive.position_counts(now_ns),
            if drive.is_enabled() {
                "enabled"
            } else {
                "disabled"
            }
        );
    }
    for drive in rig.hub_motors() {
        println!(
            "node {:>3}: {:>8} commands, now {:>6.1} r/min, {:>8} counts travelled, {}",
            drive.config().node.get(),
            drive.books().rpdos,
            drive.speed_rpm(now_ns),
            drive.travel_counts(now_ns),
            if drive.is_enabled() {
                "enabled"
            } else {
                "disabled"
            }
        );
    }
    for reset in rig.board().resets() {
        println!("reset at {} ms: {:?}", reset.at_ns / MS, reset.cause);
    }
    let soc = rig.board().soc();
    println!(
        "{} instructions, stack at most {} bytes, processor asleep {} % of the time",
        soc.instructions,
        rig.board().stack_high_water().unwrap_or(0),
        100 * soc.idle / soc.now.max(1)
    );
}
