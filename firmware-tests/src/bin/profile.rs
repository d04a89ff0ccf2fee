//! Prints by function how many instructions an image executes, standing or moving, as one line of JSON, for `cargo xtask profile`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use firmware_tests::Image;
use firmware_tests::motion::{self, Drives, Milliseconds};
use firmware_tests::names::Names;
use firmware_tests::orders;
use firmware_tests::profile::Profile;
use serde_json::{Value, json};

/// The stream begins so much before what is counted, and ends after it.
const AROUND_MS: u64 = 6_000;

/// Counts the instructions of an image of the firmware by function, on the emulated board of the variable FIRMWARE_BOARD.
#[derive(Parser)]
#[command(name = "profile")]
struct Arguments {
    /// The image
    image: PathBuf,
    /// Its axes
    #[arg(long)]
    axes: i32,
    /// Time until a drive answers, each time up to a quarter more or less, in microseconds
    #[arg(long)]
    response_us: u64,
    /// The axes move
    #[arg(long)]
    moving: bool,
    /// The axes follow the stream of a host: an image that takes orders
    #[arg(long, conflicts_with = "moving")]
    link: bool,
    /// Milliseconds to count
    #[arg(long)]
    ms: u64,
}

fn main() -> ExitCode {
    match profile(&Arguments::parse()) {
        Ok(profile) => {
            println!("{profile}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn profile(arguments: &Arguments) -> Result<Value, String> {
    let path: &Path = &arguments.image;
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let names = Names::read(path)?;
    let drives = Drives {
        count: arguments.axes,
        response_us: arguments.response_us,
    };
    let (mut rig, mut host) = if arguments.link {
        let (mut rig, mut host) = orders::enabled(image, drives);
        let stream_ms = arguments.ms.saturating_add(AROUND_MS).try_into();
        let stream_ms = stream_ms.map_err(|_| "a stream has fewer milliseconds")?;
        orders::set_moving(&mut rig, &mut host, stream_ms);
        (rig, Some(host))
    } else {
        (motion::standing(image, drives)?, None)
    };
    if arguments.moving {
        motion::set_moving(&mut rig);
    }
    rig.board_mut().soc_mut().profile = Some(Profile::default());
    let counted = Milliseconds::count(&mut rig, arguments.ms, |rig| match &mut host {
        Some(host) => host.run_ms(rig, 1),
        None => {
            rig.run_ms(1);
        }
    });
    let profile = rig.board_mut().soc_mut().profile.take().unwrap_or_default();
    let image = rig.board().image();
    let functions: Vec<Value> = profile
        .functions(image, &names)
        .into_iter()
        .map(|(function, contexts)| {
            json!({"function": function.name, "file": function.file, "instructions": contexts})
        })
        .collect();
    Ok(json!({
        "milliseconds": counted.count,
        "instructions": counted.instructions,
        "worst_millisecond": counted.worst,
        "functions": functions,
    }))
}
