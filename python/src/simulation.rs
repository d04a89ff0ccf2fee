//! A motion on simulated drives, in virtual time: the master of the firmware on a bus with exact times.

mod bench;

use board_link::segment::{
    Admission, Begin, MOST_AXES, OfAxes, Segment, SegmentConfig, SegmentQueue,
};
use board_link::{AxisLimits, WhenDry};
use dyn_can::{DriveId, GearNumber};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use pythonize::pythonize;
use serde::Serialize;
use trajectory::{Limits, Position};

use crate::errors::input_error;
use crate::plan::bit_rate;
use crate::points::{Point, SegmentMaker};
use bench::Bench;

/// Segments that are kept.
const SEGMENTS: usize = 65;
/// Some milliseconds.
const CYCLES_BETWEEN_SIGNALS: u64 = 1_000;

/// What is to be simulated; the names are those of the arguments in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wish {
    drives: Vec<i32>,
    bit_rate_kbit: u32,
    cycle_us: u32,
    max_rpm: f64,
    max_acceleration: f64,
    max_jerk: Option<f64>,
    seed: u64,
}

/// How it went, with the names of `motionctl sim --json`.
#[derive(Serialize)]
pub(crate) struct Summary {
    pub(crate) promises_kept: bool,
    pub(crate) axes: Vec<AxisSummary>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_rate_kbit: u32,
    pub(crate) cycles: u32,
    pub(crate) late_cycles: u32,
    pub(crate) late_hand_overs: u32,
    pub(crate) faults: u32,
    pub(crate) mean_bus_load: f64,
}

/// One axis of it.
#[derive(Serialize)]
pub(crate) struct AxisSummary {
    pub(crate) axis: usize,
    pub(crate) drive: u8,
    pub(crate) state: String,
    pub(crate) fault: Option<String>,
    pub(crate) set_points: u32,
    pub(crate) target_counts: i32,
    pub(crate) sent_counts: i32,
    pub(crate) received_counts: i64,
    pub(crate) position_error_counts: i64,
}

/// Simulates a motion; the axes stand at its first set-point. Gives the set-points and the positions of the motors in every cycle, as bytes
/// of 64-bit numbers, and the summary.
#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    points: Vec<(f64, Vec<f64>)>,
    wish: Wish,
) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyBytes>, Bound<'py, PyAny>)> {
    let done = py.detach(|| run(&points, &wish));
    let (set_points, positions, summary) = done.map_err(|why| match why {
        Undone::Refused(text) => input_error(py, text),
        Undone::Interrupted(error) => error,
    })?;
    Ok((
        PyBytes::new(py, &set_points),
        PyBytes::new(py, &positions),
        pythonize(py, &summary)?,
    ))
}

type Done = (Vec<u8>, Vec<u8>, Summary);

/// Why there is no result.
enum Undone {
    /// The motion cannot be played.
    Refused(String),
    /// A signal, as that of Ctrl-C, has raised an exception.
    Interrupted(PyErr),
}

impl From<String> for Undone {
    fn from(text: String) -> Self {
        Self::Refused(text)
    }
}

fn run(points: &[(f64, Vec<f64>)], wish: &Wish) -> Result<Done, Undone> {
    if !(250..=1_000_000).contains(&wish.cycle_us) {
        let text = format!("cycle_us: expected 250 to 1000000, got {}", wish.cycle_us);
        return Err(text.into());
    }
    let drives = wish.drives()?;
    let points = points_of(points, drives.len())?;
    let first = points
        .first()
        .ok_or_else(|| "expected at least one set-point, got none".to_owned())?;
    let stand: Vec<Position> = first.positions.clone();
    let limits = vec![wish.limits()?; stand.len()];
    let mut queue = SegmentQueue::<MOST_AXES, SEGMENTS>::new();
    let config = SegmentConfig::with_cycles_per_second(1_000_000 / wish.cycle_us);
    let (mut admission, mut player) = queue
        .split(&limits, config)
        .ok_or_else(|| format!("expected 1 to {MOST_AXES} axes, got {}", stand.len()))?;
    admission
        .begin(&begin(&stand), &stand, 0)
        .map_err(|refused| format!("set-point 0: {refused}"))?;
    let mut bench = Bench::new(
        &drives,
        bit_rate(wish.bit_rate_kbit)?,
        wish.cycle_us,
        wish.seed,
    )?;
    bench.bring_up()?;
    let (mut set_points, mut positions) = (Vec::new(), Vec::new());
    let mut out = stand.clone();
    let mut segments = segments_of(&points).into_iter().enumerate();
    for now in 1.. {
        if now % CYCLES_BETWEEN_SIGNALS == 0 {
            Python::attach(|py| py.check_signals()).map_err(Undone::Interrupted)?;
        }
        feed(&mut admission, &mut segments)?;
        let has_set_points = player.advance(now, &stand, &mut out);
        // One set-point is a motion of one cycle, in which the axes stand.
        if !has_set_points && !player.phase().is_active() && now > 1 {
            break;
        }
        let offsets = out.iter().zip(&stand);
        let offsets: Vec<i32> = offsets
            .map(|(out, stand)| out.counts() - stand.counts())
            .collect();
        let motors = bench.cycle(&offsets);
        for ((out, stand), motor) in out.iter().zip(&stand).zip(motors) {
            set_points.extend(i64::from(out.counts()).to_ne_bytes());
            positions.extend((motor + i64::from(stand.counts())).to_ne_bytes());
        }
        if bench.has_failed() || !player.phase().is_active() {
            break;
        }
    }
    let last = points.last().unwrap_or(first);
    let way = last.positions.iter().zip(&stand);
    let way: Vec<i32> = way
        .map(|(last, stand)| last.counts() - stand.counts())
        .collect();
    Ok((set_points, positions, bench.finish(&way)))
}

/// As soon as there is something to play.
fn begin(stand: &[Position]) -> Begin {
    Begin {
        stream: 1,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: stand
            .iter()
            .map(|position| position.units())
            .collect::<OfAxes<i64>>(),
    }
}

fn segments_of(points: &[Point]) -> Vec<Segment> {
    let mut points = points.iter().cloned();
    let Some(mut maker) = points.next().map(SegmentMaker::new) else {
        return Vec::new();
    };
    let mut segments: Vec<Segment> = points.filter_map(|point| maker.push(point)).collect();
    segments.extend(maker.finish());
    segments
}

/// What the queue has room for; segment 0 leads to set-point 1.
fn feed(
    admission: &mut Admission<'_, MOST_AXES>,
    segments: &mut impl Iterator<Item = (usize, Segment)>,
) -> Result<(), String> {
    while admission.credit() > 0 {
        let Some((index, segment)) = segments.next() else {
            return admission
                .end(1)
                .map_err(|refused| format!("the end: {refused}"));
        };
        admission
            .push(1, index as u32, &segment)
            .map_err(|refused| format!("set-point {}: {refused}", index + 1))?;
    }
    Ok(())
}

fn points_of(points: &[(f64, Vec<f64>)], axes: usize) -> Result<Vec<Point>, String> {
    let mut checked: Vec<Point> = Vec::with_capacity(points.len());
    for (index, (cycles, counts)) in points.iter().enumerate() {
        if counts.len() != axes {
            return Err(format!(
                "set-point {index}: expected {axes} positions, one for each drive, got {}",
                counts.len()
            ));
        }
        let point =
            Point::of(*cycles, counts).map_err(|text| format!("set-point {index}: {text}"))?;
        if let Some(before) = checked.last()
            && point.time <= before.time
        {
            return Err(format!(
                "set-point {index}: the time: expected later than {} cycles, got {cycles}",
                before.time.cycles()
            ));
        }
        checked.push(point);
    }
    Ok(checked)
}

impl Wish {
    fn drives(&self) -> Result<Vec<DriveId>, String> {
        let mut drives: Vec<DriveId> = Vec::new();
        for &drive in &self.drives {
            let drive = DriveId::new(drive).map_err(|error| format!("drives: {error}"))?;
            if drives.contains(&drive) {
                return Err(format!(
                    "drives: expected each drive once, got {drive} twice"
                ));
            }
            drives.push(drive);
        }
        if drives.is_empty() {
            return Err("drives: expected at least one, got none".to_owned());
        }
        Ok(drives)
    }

    /// In counts and cycles.
    fn limits(&self) -> Result<AxisLimits, String> {
        let turn = f64::from(dyn_can::units::command_counts_per_turn(gear()?));
        let cycle_s = f64::from(self.cycle_us) / 1e6;
        let velocity = (self.max_rpm / 60.0 * turn * cycle_s) as f32;
        let acceleration = (self.max_acceleration / 60.0 * turn * cycle_s * cycle_s) as f32;
        let limits = match self.max_jerk {
            None => Limits::without_jerk(velocity, acceleration),
            Some(jerk) => {
                let jerk = (jerk / 60.0 * turn * cycle_s * cycle_s * cycle_s) as f32;
                Limits::new(velocity, acceleration, jerk)
            }
        };
        let motion = limits.map_err(|error| format!("limits: {error}"))?;
        Ok(AxisLimits {
            motion,
            lowest: Position::from_counts(i32::MIN),
            highest: Position::from_counts(i32::MAX),
        })
    }
}

/// That of the simulated drives.
fn gear() -> Result<GearNumber, String> {
    GearNumber::new(4_096).map_err(|error| error.to_string())
}
