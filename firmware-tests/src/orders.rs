//! A board that takes orders at work: its drives, a host that streams and reads snapshots, and what that costs the cycle.

use board_link::WhenDry;
use board_link::host::Incoming;
use board_link::message::{Answer, Request};
use board_link::segment::{AxisSegment, Segment, Shape};
use board_settings::{AxisSettings, BusSettings, Inputs, MotorLimits, Settings, Travel};
use drive_sim::DynDrive;
use trajectory::Time;

use crate::Image;
use crate::host::Host;
use crate::load::THREAD;
use crate::motion::Drives;
use crate::rig::{Contact, Rig};

/// Cycles from one snapshot to the next: 50 in a second.
const SNAPSHOT_CYCLES: u32 = 20;
/// Longest pause of the host.
const PAUSE_MS: u64 = 20;
/// Length of a segment: 50 in a second, as of a program that plans in steps of 20 ms.
const SEGMENT_CYCLES: u32 = 20;
/// A stroke there and back.
const STROKE_COUNTS: f64 = 20_000.0;
const STROKE_CYCLES: u32 = 1_000;
const SETTLED_MS: u64 = 1_000;
const READY_MS: u64 = 1_500;

/// What the handlers of the cycle and of the bus took, the thread apart.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Handlers {
    /// Instructions in a millisecond, on average.
    pub mean: f64,
    /// The most of them in one.
    pub worst: u64,
    /// Instructions of the thread in a millisecond, on average.
    pub thread: f64,
}

impl Handlers {
    /// Counts so many milliseconds, in each of which `run` lets one pass.
    pub fn count(rig: &mut Rig, ms: u64, mut run: impl FnMut(&mut Rig)) -> Self {
        let all = |rig: &Rig, is_thread: bool| -> u64 {
            let loads = rig.board().accounts().loads().iter();
            loads
                .filter(|(context, _)| (**context == THREAD) == is_thread)
                .map(|(_, load)| load.instructions)
                .sum()
        };
        rig.board_mut().clear_accounts();
        let (mut worst, mut before) = (0, 0);
        for _ in 0..ms {
            run(rig);
            let now = all(rig, false);
            worst = worst.max(now - before);
            before = now;
        }
        let mean = |instructions: u64| instructions as f64 / ms as f64;
        Self {
            mean: mean(before),
            worst,
            thread: mean(all(rig, true)),
        }
    }
}

/// Settings for so many axes: drives from 1 on, 600 r/min, 8000 r/min per second, 1 Mbit/s, the whole travel. With more than eleven the bus
/// has no room for polls.
#[must_use]
pub fn settings(axes: u8) -> Settings {
    const MOST_WITH_POLLS: u8 = 11;
    let limits = MotorLimits {
        speed_rpm: 600,
        acceleration_rpm_per_s: 8_000,
    };
    let whole = Travel::Counts {
        min: -(1 << 27),
        max: (1 << 27) - 1,
    };
    let axis = |drive| {
        let mut axis = AxisSettings::new(drive, 4_096, limits, whole);
        if axes > MOST_WITH_POLLS {
            (axis.polls.status_us, axis.polls.position_us) = (0, 0);
            axis.unwatched = true;
        }
        axis
    };
    Settings {
        name: "test".try_into().expect("a short name"),
        bus: BusSettings::new(1_000),
        inputs: Inputs::default(),
        axes: (1..=axes).map(axis).collect(),
    }
}

/// Writes settings over the link and starts the board anew, as a user does.
///
/// # Panics
/// When the board refuses them.
pub fn set_up(rig: &mut Rig, host: &mut Host, settings: &Settings) {
    host.connect(rig);
    let written = host.write_settings(rig, settings);
    assert_eq!(written, Ok(Answer::Done), "{:#?}", rig.board().log());
    rig.cut_power(1_000, 100_000, 0);
    let is_lost = host.run_until(rig, 3_000, |host, _| {
        host.told.contains(&Incoming::Disconnected)
    });
    assert!(is_lost, "the board was off");
    host.told.clear();
    host.connect(rig);
}

/// A board whose axes are enabled by a host.
///
/// # Panics
/// When it does not get there.
#[must_use]
pub fn enabled(image: Image, drives: Drives) -> (Rig, Host) {
    let mut rig = Rig::with_drives(image, (1..=drives.count).map(|id| drives.config(id)));
    let mut host = Host::new(&mut rig, 1);
    set_up(&mut rig, &mut host, &settings(drives.count as u8));
    rig.close(Contact::Stop);
    rig.close(Contact::Enable);
    host.run_ms(&mut rig, READY_MS);
    host.connect(&mut rig);
    assert_eq!(host.ask(&mut rig, Request::Enable), Ok(Answer::Done));
    assert!(rig.servos().all(DynDrive::is_enabled));
    host.run_ms(&mut rig, SETTLED_MS);
    (rig, host)
}

/// Lets every axis follow a stream for `ms`, with snapshots beside it.
pub fn set_moving(rig: &mut Rig, host: &mut Host, ms: u32) {
    let asked = Request::Snapshots {
        period: SNAPSHOT_CYCLES,
    };
    host.look_at_machine(rig);
    let stand: Vec<i32> = host.snapshot.axes.iter().map(|axis| axis.target).collect();
    host.stream(rig, 1, strokes(&stand, ms), WhenDry::End);
    assert_eq!(host.ask(rig, asked), Ok(Answer::Done));
    host.pause_up_to(PAUSE_MS);
    host.run_ms(rig, SETTLED_MS);
}

/// Strokes in steps of [`SEGMENT_CYCLES`], each a curve of fifth degree.
fn strokes(stand: &[i32], ms: u32) -> Vec<Segment> {
    let strokes = ms.div_ceil(2 * STROKE_CYCLES).max(1);
    let steps = 2 * STROKE_CYCLES / SEGMENT_CYCLES;
    let segment = |step: u32| {
        let at = |step: u32| f64::from(step) / f64::from(steps) * std::f64::consts::TAU;
        let (from, to) = (at(step), at(step + 1));
        let width = to - from;
        let units = |counts: f64| (counts * f64::from(1 << 24)).round() as i64;
        let half = STROKE_COUNTS / 2.0;
        let axes = stand.iter().map(|stand| AxisSegment {
            end: (i64::from(*stand) << 24) + units(half * (1.0 - to.cos())),
            shape: Shape::Quintic {
                leaving: units(half * from.sin() * width),
                leaving_acceleration: units(half * from.cos() * width * width / 2.0),
                arriving: units(half * to.sin() * width),
                arriving_acceleration: units(half * to.cos() * width * width / 2.0),
            },
        });
        Segment {
            duration: Time::from_cycles(SEGMENT_CYCLES).ticks(),
            axes: axes.collect(),
        }
    };
    // It begins and ends at rest, but for its acceleration.
    (0..strokes).flat_map(|_| (0..steps).map(segment)).collect()
}
