//! Measures an image with standing and with moving axes and prints the figures as one line of JSON, for `cargo xtask cost`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use clap::Parser;
use firmware_tests::load::Masked;
use firmware_tests::motion::{self, Drives, Milliseconds};
use firmware_tests::{Image, Rig, names};
use serde_json::{Map, Value, json};

/// Milliseconds that are counted standing, and again moving: the firmware writes a line of the log each second.
const MILLISECONDS: u64 = 2_000;

/// Measures an image of the firmware, standing and moving, on the emulated board of the variable FIRMWARE_BOARD.
#[derive(Parser)]
#[command(name = "measure")]
struct Arguments {
    /// The image
    image: PathBuf,
    /// Its axes
    #[arg(long)]
    axes: i32,
    /// Times until a drive answers, each time up to a quarter more or less, in microseconds
    #[arg(long, value_delimiter = ',')]
    response_us: Vec<u64>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match measure_all(&arguments) {
        Ok(figures) => {
            println!("{}", Value::from(figures));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The figures of each time, in the order of the times; as many at once as there are processors.
fn measure_all(arguments: &Arguments) -> Result<Vec<Value>, String> {
    let times = &arguments.response_us;
    let next = AtomicUsize::new(0);
    let work = || {
        let mut measured = Vec::new();
        while let Some(&response_us) = times.get(next.fetch_add(1, Ordering::Relaxed)) {
            let drives = Drives {
                count: arguments.axes,
                response_us,
            };
            measured.push((response_us, measure(&arguments.image, drives)));
        }
        measured
    };
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let mut measured: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|worker| worker.join().expect("a measurement does not panic"))
            .collect()
    });
    measured.sort_by_key(|(response_us, _)| times.iter().position(|time| time == response_us));
    measured.into_iter().map(|(_, figures)| figures).collect()
}

fn measure(path: &Path, drives: Drives) -> Result<Value, String> {
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let mut rig = motion::standing(image, drives)
        .map_err(|error| format!("{} us: {error}", drives.response_us))?;
    let stack_at_start = rig.board().stack_high_water();
    rig.board_mut()
        .repaint_stack()
        .map_err(|error| format!("emulator: {error:?}"))?;
    let standing = figures(&mut rig);
    motion::set_moving(&mut rig);
    let moving = figures(&mut rig);
    Ok(json!({
        "response_us": drives.response_us,
        "standing": standing,
        "moving": moving,
        "stack_at_start": stack_at_start,
        "stack_in_motion": rig.board().stack_high_water(),
    }))
}

fn figures(rig: &mut Rig) -> Value {
    rig.board_mut().clear_accounts();
    rig.board_mut().soc_mut().masked = Masked::default();
    let counted = Milliseconds::count(rig, MILLISECONDS, |rig| {
        rig.run_ms(1);
    });
    let image = rig.board().image();
    let contexts: Map<String, Value> = rig
        .board()
        .accounts()
        .loads()
        .iter()
        .map(|(&exception, load)| {
            let mean = load.instructions as f64 / counted.count as f64;
            (names::exception(image, exception), mean.into())
        })
        .collect();
    json!({
        "mean": counted.mean(),
        "worst": counted.worst,
        "worst_without_line": counted.worst_without_line,
        "contexts": contexts,
        "masked": rig.board().soc().masked.longest,
    })
}
