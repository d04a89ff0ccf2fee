//! Any bytes as a motion file: no panic, no endless loop, memory that the size of the file bounds, and an error that says where.
//!
//! `FUZZ_INPUTS=1000000 FUZZ_SEED=7 cargo test --release -p motionctl --bin motionctl trajectory::fuzz` is the long run; without
//! them it is 20,000 inputs of seed 0. A failure names the seed of its input: `FUZZ_SEED=<seed> FUZZ_INPUTS=1` repeats it.

use drive_sim::split_mix::SplitMix64;
use dyn_can::StepLimit;

use super::columns::ColumnChoice;
use super::table::{Reading, Table};
use super::unit::{AxisScale, TimeUnit, Unit};
use super::{Interpolation, Plan, TrajectoryError, resolve};

/// Files to be damaged.
const FILES: [&str; 10] = [
    "t,a,b\n0,0,0\n0.5,10,5\n1,20,0\n",
    "time_ms;x_mm;y_mm\r\n0;0;0\r\n500;10;5\r\n1000;20;0\r\n",
    "\u{feff}# note\nq1\tq2\ttime\n0\t0\t0\n10\t5\t0.5\n",
    "0 0\n1 5\n2 5\n3 1\n",
    "0,,0\n0.5,,5\n1,,0\n",
    ",t,a,b\n0,0.0,0,\n1,0.5,10,1\n",
    "t,pos,vel,acc\n0,0,0,0\n0.5,5,20,40\n",
    "t,a\n1700000000000000000,0\n1700000000500000000,10\n",
    "\"t\",\"a [deg]\"\n\"0,0\",\"1\"\n\"1\",\"2\"\n",
    "# t a\n0 1e-300\n1e-3 2e+300\n",
];

/// Pieces that readers stumble over.
const PIECES: [&str; 26] = [
    ",",
    ";",
    "\t",
    " ",
    "\n",
    "\r",
    "\r\n",
    "\"",
    "#",
    "%",
    "-",
    "e",
    "E",
    ".",
    "0",
    "9",
    "1e308",
    "nan",
    "inf",
    "[",
    "]",
    "\u{feff}",
    "\0",
    "\u{b0}",
    "99999999999999999999999999",
    "time",
];

/// A file and how to read it.
fn input(random: &mut SplitMix64) -> (Vec<u8>, Reading) {
    let pick = |random: &mut SplitMix64, count: usize| random.up_to(count as u64 - 1) as usize;
    let mut bytes = FILES[pick(random, FILES.len())].as_bytes().to_vec();
    for _ in 0..random.up_to(6) {
        let place = pick(random, bytes.len() + 1);
        match random.up_to(4) {
            0 => bytes.truncate(place),
            1 => {
                let end = (place + pick(random, 8)).min(bytes.len());
                bytes.drain(place..end);
            }
            2 => {
                let copied = bytes[place..(place + pick(random, 40)).min(bytes.len())].to_vec();
                let at = pick(random, bytes.len() + 1);
                bytes.splice(at..at, copied);
            }
            3 => bytes.insert(place, random.up_to(255) as u8),
            _ => {
                let piece = PIECES[pick(random, PIECES.len())];
                bytes.splice(place..place, piece.bytes());
            }
        }
    }
    let maybe = |random: &mut SplitMix64| random.up_to(3) == 0;
    let column = |random: &mut SplitMix64| {
        ["1", "2", "3", "t", "a", "0", "1-2", "2-99999999999"][pick(random, 8)].to_owned()
    };
    let reading = Reading {
        choice: ColumnChoice {
            time: maybe(random).then(|| column(random)),
            positions: if maybe(random) {
                vec![column(random)]
            } else {
                Vec::new()
            },
            axes: maybe(random).then(|| pick(random, 5)),
            speeds: maybe(random),
        },
        time_unit: maybe(random).then(|| TimeUnit::ALL[pick(random, 4)]),
        decimal_comma: maybe(random),
        most_duration_s: 100.0,
        most_numbers: 10_000,
    };
    (bytes, reading)
}

/// Reads a file as far as a motion, and checks what comes out.
fn run(bytes: &[u8], reading: &Reading) -> Result<(), String> {
    let table = match Table::read(bytes, reading) {
        Ok(table) => table,
        Err(error) => return says_where(&error),
    };
    let held = 8 * (table.times_s.capacity() + table.lines.capacity() + table.held());
    // A point takes at least four bytes of the file, and a growing list twice what it holds; the first ones take four places.
    let most = 64 * bytes.len() + 256;
    if held > most {
        return Err(format!(
            "{held} bytes are held for a file of {}",
            bytes.len()
        ));
    }
    let columns = &table.columns.positions;
    let units = match resolve::position_units(&[], columns) {
        Ok(units) => units,
        Err(error) => return says_where(&error),
    };
    let scale = |unit: &Unit| AxisScale {
        unit: *unit,
        gear_ratio: 1.0,
        counts_per_turn: 16_384.0,
        mm_per_turn: 5.0,
    };
    let scales: Vec<AxisScale> = units.iter().map(scale).collect();
    let limits = vec![StepLimit::MAX; scales.len()];
    match Plan::new(&table, &scales, Interpolation::Monotone, 100_000, &limits) {
        Ok(plan) => {
            let first: Vec<i32> = plan.row(0);
            let is_right =
                first.iter().all(|counts| *counts == 0) && plan.last().len() == columns.len();
            is_right
                .then_some(())
                .ok_or_else(|| format!("starts at {first:?}"))
        }
        Err(error) => says_where(&error),
    }
}

/// An error names a line, a column or an option.
fn says_where(error: &TrajectoryError) -> Result<(), String> {
    let text = error.to_string();
    let is_about_the_whole = matches!(error, TrajectoryError::Empty);
    if text.starts_with("line ") || text.contains("column") || is_about_the_whole {
        Ok(())
    } else {
        Err(format!("no place in: {text}"))
    }
}

#[test]
fn any_bytes_are_read_or_refused() {
    let number = |name: &str, default| {
        let given = std::env::var(name).ok();
        given.map_or(default, |text| {
            text.parse()
                .unwrap_or_else(|_| panic!("{name} is a number"))
        })
    };
    let (inputs, seed): (u64, u64) = (number("FUZZ_INPUTS", 20_000), number("FUZZ_SEED", 0));
    let mut read = 0_u64;
    for seed in seed..seed + inputs {
        let (bytes, reading) = input(&mut SplitMix64::new(seed));
        let outcome = std::panic::catch_unwind(|| run(&bytes, &reading));
        let text = String::from_utf8_lossy(&bytes);
        match outcome {
            Ok(Ok(())) => {}
            Ok(Err(fault)) => panic!("seed {seed}: {fault}\n{text:?}\n{reading:?}"),
            Err(_) => panic!("seed {seed}: a panic\n{text:?}\n{reading:?}"),
        }
        read += u64::from(Table::read(&bytes[..], &reading).is_ok());
    }
    crate::output::tell(format_args!(
        "{inputs} inputs from seed {seed}: {read} were motions, the others were refused"
    ));
    // Inputs that are all refused would test the refusals alone.
    assert!(inputs < 1_000 || read > inputs / 100, "{read} of {inputs}");
}
