//! The family of the example of `can-motion`, with its own simulated drive.

#[path = "../../../crates/can-motion/examples/third_family.rs"]
#[allow(
    dead_code,
    unreachable_pub,
    unfulfilled_lint_expectations,
    reason = "a program of its own"
)]
mod third_family;

use can_motion::facts::Facts;
use can_motion::family::{CommonFault, CycleConfig, CycleUs, ValueLimits};
use can_motion::{CommonEvent, Confirmation, Master, Reason};
use dyn_can::DataFrame;
use fastrand::Rng;

use super::subject::{AXES, Answer, Asked, AxisRules, Command, Rules, Seen, Subject, Told};
use third_family::{SimulatedToy, Toy, ToyAxis, ToyFault};

const CYCLE: CycleUs = CycleUs(1_000);

/// Three drives of the example.
#[derive(Debug)]
pub struct Thirds {
    axes: Vec<ToyAxis>,
    drives: Vec<SimulatedToy>,
    is_undisturbed: [bool; AXES],
    /// Not disturbed since its position was told.
    is_told: [bool; AXES],
    silent_until_us: [u64; AXES],
}

impl Subject for Thirds {
    type Family = Toy;

    fn draw(random: &mut Rng) -> Self {
        let axes = (1..=AXES as u8).map(|drive| {
            let max_step = random.u32(1..=100);
            let change = random.u32(1..=max_step);
            let limits = ValueLimits::new(-5_000, random.i32(500..9_000), max_step, change);
            ToyAxis { drive, limits }
        });
        let axes = axes.collect();
        let drives = (0..AXES).map(|_| SimulatedToy {
            is_on: random.bool(),
            has_alarm: false,
            position: random.i32(-300..300),
        });
        let drives = drives.collect();
        Self {
            axes,
            drives,
            is_undisturbed: [false; AXES],
            is_told: [false; AXES],
            silent_until_us: [0; AXES],
        }
    }

    fn master(&self) -> Master<AXES, Toy> {
        Master::new(CYCLE, &self.axes).expect("axes that work")
    }

    fn rules(&self) -> Rules {
        let axes = |axis: usize| {
            let limits = self.axes[axis].limits;
            AxisRules {
                min: limits.min,
                max: limits.max,
                max_step: limits.max_step as i32,
                ramp_cycles: (limits.max_step / limits.max_step_change) as i32 + 1,
            }
        };
        Rules {
            cycle_us: u64::from(CYCLE.cycle_us()),
            stuck_us: u64::from(CYCLE.stuck_us()),
            confirm_us: u64::from(CYCLE.confirm_us()),
            reply_us: u64::MAX / 2,
            standstill_us: 0,
            requests_per_cycle: 1,
            groups: [0; AXES],
            axes: [axes(0), axes(1), axes(2)],
            asks_one_at_a_time: false,
            is_asked: true,
            is_absolute: true,
            has_cycle_frames: false,
            anchors_after_enable: false,
            is_speed: false,
            alarm_frees_shaft: true,
        }
    }

    fn axis_of(frame: &DataFrame) -> Option<usize> {
        usize::from(frame.id() & 0x7F)
            .checked_sub(1)
            .filter(|axis| *axis < AXES)
    }

    fn question_of(frame: &DataFrame) -> u16 {
        frame.id() & !0x80
    }

    fn command(&self, frame: &DataFrame) -> Command {
        match (frame.id() & 0x780, frame.data()) {
            (0x100, &[a, b, c, d]) => Command::Target(i32::from_le_bytes([a, b, c, d])),
            (0x200, [0]) => Command::Off,
            (0x200, _) => Command::On,
            _ => Command::Ask,
        }
    }

    fn told(&self, frame: &DataFrame) -> Told {
        match (frame.id() & 0x780, frame.data()) {
            (0x380, &[flags, a, b, c, d]) => Told {
                power: Some(flags & 1 != 0),
                stands: Some(flags & 4 != 0),
                position: Some(i32::from_le_bytes([a, b, c, d])),
                is_alarm: flags & 2 != 0,
                ..Told::default()
            },
            _ => Told::default(),
        }
    }

    fn take(
        &mut self,
        now_us: u64,
        frame: &DataFrame,
        asked: Asked,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    ) {
        let Some(axis) = Self::axis_of(frame) else {
            return;
        };
        let moves = matches!(self.command(frame), Command::Target(_));
        if now_us < self.silent_until_us[axis] {
            (self.is_undisturbed[axis], self.is_told[axis]) = (false, false);
            return;
        }
        self.is_undisturbed[axis] &= !moves || self.drives[axis].is_on;
        self.is_told[axis] |= self.command(frame) == Command::Ask;
        let frame = self.drives[axis].take(frame);
        let due_us = now_us + random.u64(0..700);
        answers.extend(frame.map(|frame| Answer {
            due_us,
            frame,
            asked: Some(asked),
        }));
    }

    fn pass(&mut self, _: u64, _: &mut Rng, _: &mut Vec<Answer>) {}

    fn disturb(
        &mut self,
        axis: usize,
        now_us: u64,
        random: &mut Rng,
        _: &mut Vec<Answer>,
    ) -> &'static str {
        (self.is_undisturbed[axis], self.is_told[axis]) = (false, false);
        let drive = &mut self.drives[axis];
        match random.u8(..5) {
            0 => {
                (drive.has_alarm, drive.is_on) = (true, false);
                "alarms"
            }
            1 => {
                drive.has_alarm = false;
                "loses its alarm"
            }
            2 => {
                drive.is_on = !drive.has_alarm;
                "is switched on by somebody else"
            }
            3 => {
                (drive.is_on, drive.position) = (false, 0);
                "reboots"
            }
            _ => {
                self.silent_until_us[axis] = now_us + random.u64(1_000..100_000);
                "falls silent"
            }
        }
    }

    fn seen(&self, _: usize, kind: &CommonEvent<ToyFault>) -> Seen {
        match kind {
            CommonEvent::Fault(fault) => Seen::Fault {
                is_own: *fault != ToyFault::Common(CommonFault::Group),
                is_bus: matches!(
                    fault,
                    ToyFault::Common(CommonFault::Bus | CommonFault::Lost)
                ),
                ramps: false,
                ramps_itself: false,
                disables: false,
            },
            CommonEvent::State { from, to, reason } => Seen::State {
                from: *from,
                to: *to,
                by_fault: *reason == Reason::Fault,
                is_back: false,
            },
            _ => Seen::Other,
        }
    }

    fn procedure(_: &mut Rng) -> Option<((), Confirmation)> {
        Some(((), Confirmation::Given))
    }

    fn sent(snapshot: &(can_motion::AxisState, Option<ToyFault>, i32)) -> i32 {
        snapshot.2
    }

    fn compares(_: &Facts) -> bool {
        true
    }

    fn undisturbed_position(&self, axis: usize) -> Option<i64> {
        let is_told = self.drives[axis].is_on && self.is_undisturbed[axis];
        is_told.then_some(i64::from(self.drives[axis].position))
    }

    fn anchored(&mut self, axis: usize) {
        self.is_undisturbed[axis] = self.is_told[axis];
    }
}
