//! What goes over the wire to wheels, read without the codec, against what the application asked for.

use can_motion::AxisState;
use can_motion::wheel::{WheelConfig, WheelFault, WheelMode};
use drive_sim::{Frame, Outcome, Record};
use embedded_can::{Frame as _, Id};

use crate::campaign::violation::{Promise, Violation};

/// Frames that a controller with three mailboxes may still hold when a fault is noticed.
const HELD_FRAMES: u32 = 3;
/// A bus on which no frame gets through for so long must show on a wheel that streams.
pub(super) const OUTAGE_SHOWS_US: u64 = 100_000;
/// Command PDO of a node: 300h and the node (mapped by the master).
const COMMAND_ID: u16 = 0x300;
const ENABLE_OPERATION: u8 = 0x0F;

#[derive(Debug, Clone, Copy, Default)]
struct Watched {
    /// The application asked for power.
    may_be_on: bool,
    /// Value of the last command that enables operation.
    value: Option<i32>,
    is_faulted: bool,
    is_ramping: bool,
    /// Commands behind a fault that still moved the wheel.
    behind_fault: u32,
    /// It was halted since its last command.
    is_halted: bool,
    /// It streams since the bus failed, and must have stopped by then.
    stops_by_us: Option<u64>,
}

#[derive(Debug)]
pub(super) struct Observer {
    limits: Vec<(bool, i32, i32)>,
    wheels: Vec<Watched>,
    pub(super) faults: Vec<String>,
    pub(super) moved: bool,
}

impl Observer {
    pub(super) fn new(wheels: &[WheelConfig]) -> Self {
        let limits = wheels.iter().map(|wheel| {
            let values = wheel.limits.values;
            // A speed and a torque are nothing at 0; a position moves when it changes.
            let ends_at_0 = !matches!(wheel.mode, WheelMode::Position { .. });
            // A target is taken by an edge, so a position goes out in every second cycle.
            let step = values.max_step as i32 * if ends_at_0 { 1 } else { 2 };
            (ends_at_0, values.max, step)
        });
        Self {
            limits: limits.collect(),
            wheels: vec![Watched::default(); wheels.len()],
            faults: Vec::new(),
            moved: false,
        }
    }

    pub(super) fn may_be_on(&mut self, wheel: usize) {
        self.wheels[wheel].may_be_on = true;
    }

    pub(super) fn may_move(&mut self, wheel: usize) {
        (
            self.wheels[wheel].is_faulted,
            self.wheels[wheel].behind_fault,
        ) = (false, 0);
    }

    pub(super) fn faulted(&mut self, wheel: usize, fault: WheelFault, now_us: u64) {
        self.faults
            .push(format!("{now_us} us: wheel {wheel}: {fault:?}"));
        self.wheels[wheel].is_faulted = true;
    }

    pub(super) fn bus_fails(&mut self, wheel: usize, now_us: u64) {
        self.wheels[wheel].stops_by_us = Some(now_us + OUTAGE_SHOWS_US);
    }

    /// The application ended every set-point at once.
    pub(super) fn halts(&mut self, wheel: usize) {
        self.wheels[wheel].is_halted = true;
    }

    /// The application began no cycle: what a master must notice shows when it is called again.
    pub(super) fn misses_cycle(&mut self, cycle_us: u64) {
        for wheel in &mut self.wheels {
            wheel.stops_by_us = wheel.stops_by_us.map(|at_us| at_us + cycle_us);
        }
    }

    /// A cycle has ended with the wheel in a state.
    pub(super) fn state(
        &mut self,
        wheel: usize,
        state: AxisState,
        now_us: u64,
    ) -> Result<(), Violation> {
        let watched = &mut self.wheels[wheel];
        watched.is_ramping = state == AxisState::RampingDown;
        if state == AxisState::Ready {
            (watched.may_be_on, watched.value) = (false, None);
        }
        if state != AxisState::Streaming {
            watched.stops_by_us = None;
        }
        match watched.stops_by_us {
            Some(at_us) if now_us > at_us => broken(
                Promise::Noticed,
                now_us,
                format!("wheel {wheel} streams on, and no frame gets through"),
            ),
            _ => Ok(()),
        }
    }

    /// A frame of the master ended on the wire.
    pub(super) fn on_wire(&mut self, record: &Record) -> Result<(), Violation> {
        let now_us = record.end_ns / 1_000;
        let Some((wheel, word, value)) = command(&record.frame) else {
            return Ok(());
        };
        if record.outcome != Outcome::Delivered {
            return Ok(());
        }
        let Some(&(ends_at_0, max, step)) = self.limits.get(wheel) else {
            return broken(
                Promise::Commands,
                now_us,
                format!("{} goes to no wheel", record.frame),
            );
        };
        let watched = &mut self.wheels[wheel];
        if word & 0x8F != ENABLE_OPERATION {
            // The wheel stops: its speed is 0, and a position is anchored anew.
            watched.value = ends_at_0.then_some(0);
            watched.is_halted = false;
            return Ok(());
        }
        if !watched.may_be_on {
            return broken(
                Promise::Commands,
                now_us,
                format!("wheel {wheel}: nobody asked for {}", record.frame),
            );
        }
        let before = watched.value.replace(value);
        // Halted and resumed between two frames: the speed begins anew at 0, behind what the controller held.
        let is_anew = watched.is_halted && ends_at_0 && value.unsigned_abs() <= step.unsigned_abs();
        watched.is_halted &= !is_anew;
        let from = if is_anew { Some(0) } else { before };
        let change = from.map_or(0, |from| value.abs_diff(from));
        let moves = if ends_at_0 { value != 0 } else { change != 0 };
        self.moved |= moves;
        if watched.is_faulted && moves && !watched.is_ramping {
            watched.behind_fault += 1;
            if watched.behind_fault > HELD_FRAMES {
                return broken(
                    Promise::FaultStops,
                    now_us,
                    format!("wheel {wheel}: {} behind a fault", record.frame),
                );
            }
        }
        // A speed may fall to 0 at once: that is a halt.
        let is_halt = ends_at_0 && value == 0;
        if (ends_at_0 && value.abs() > max) || (change > step.unsigned_abs() && !is_halt) {
            return broken(
                Promise::Limits,
                now_us,
                format!(
                    "wheel {wheel}: from {before:?} to {value}, at most {step} further and {max}"
                ),
            );
        }
        Ok(())
    }
}

pub(super) fn broken(promise: Promise, at_us: u64, what: String) -> Result<(), Violation> {
    Err(Violation {
        promise,
        at_us,
        what,
    })
}

/// Wheel, low byte of the control word, and value of a command.
fn command(frame: &Frame) -> Option<(usize, u8, i32)> {
    let Id::Standard(id) = frame.id() else {
        return None;
    };
    let node = id
        .as_raw()
        .checked_sub(COMMAND_ID)
        .filter(|node| (1..=127).contains(node))?;
    let (word, value) = match *frame.data() {
        [word, _, a, b, c, d] => (word, i32::from_le_bytes([a, b, c, d])),
        // A torque has 16 bits.
        [word, _, a, b] => (word, i16::from_le_bytes([a, b]).into()),
        _ => return None,
    };
    Some((usize::from(node) - 1, word, value))
}
