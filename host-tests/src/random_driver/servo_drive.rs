//! DYN drives as the CAN document of the maker describes them: identifiers are `drive * 32 + function`, numbers have the highest byte first.

use can_motion::{
    AxisConfig, AxisSnapshot, Confirmation, Dyn, EventKind, Fault, GroupId, Limits, Master,
    MasterConfig, Procedure, Reaction, Reactions, StepChange, Timeouts, Travel, WearLimits,
};
use dyn_can::{DataFrame, DriveId, GearNumber, SetParamGroup2, StepLimit};
use fastrand::Rng;

use super::subject::{
    AXES, Answer, Asked, AxisRules, Command, GROUP_OF, Rules, Seen, Subject, Told,
};

const SET_ORIGIN: u16 = 0x00;
const GO_TO: u16 = 0x01;
const GO_BY: u16 = 0x03;
const LOAD_TO: u16 = 0x16;
const LOAD_BY: u16 = 0x17;
const TRIGGER: u16 = 0x18;
const READ_ID: u16 = 0x06;
const READ_CONFIG: u16 = 0x08;
const READ_STATUS: u16 = 0x09;
const GENERAL_READ: u16 = 0x0E;
const READ_GROUP2: u16 = 0x14;
const READ_GROUP3: u16 = 0x15;
const SERVO_DISABLE: u16 = 0x19;
const READ_SPEED: u16 = 0x1A;
const DRIVE_RESET: u16 = 0x1B;
const STEP: u16 = 0x1C;
const DRIVE_ERROR: u16 = 0x1D;
const ECHO: u16 = 0x1E;
const COUNTER: u16 = 0x1F;

/// Counts in a millisecond of a drive that moves by itself: less than MaxSpd 5 gives.
const OWN_SPEED: i64 = 10;

/// Functions that change a drive.
const CHANGES: [u16; 7] = [SET_ORIGIN, 0x05, 0x07, 0x10, 0x11, 0x12, DRIVE_RESET];

/// One drive.
#[derive(Debug, Clone)]
struct ServoDrive {
    is_on: bool,
    alarm: u8,
    position: i64,
    /// A number that changes when the shaft is moved by something else than the master.
    disturbances: u32,
    /// The number when the position was told last.
    told_at: u32,
    /// The number when the position that became an anchor was told.
    anchored_at: u32,
    /// When the shaft comes to rest.
    turns_until_us: u64,
    /// It answers and obeys from then on.
    silent_until_us: u64,
    group2: [u8; 2],
    counter: u8,
    /// Where it goes by itself.
    goes_to: Option<i64>,
    /// The places and distances that a trigger starts.
    loaded: [Option<i64>; 2],
}

/// Drives 1, 2 and 3.
#[derive(Debug)]
pub struct Servos {
    config: MasterConfig,
    axes: Vec<AxisConfig>,
    drives: Vec<ServoDrive>,
    loses_answers: bool,
    /// A trigger leaves what was loaded: the documents do not say (D57).
    keeps_loads: bool,
    triggered: [bool; AXES],
    passed_us: Option<u64>,
}

/// A number in as few bytes as it needs.
fn number(value: i64) -> Vec<u8> {
    let bytes = (value as i32).to_be_bytes();
    let fits = |len: u32| {
        let half = 1_i64 << (8 * len - 1);
        (-half..half).contains(&value)
    };
    let len = (1..4).find(|len| fits(*len)).unwrap_or(4) as usize;
    bytes[4 - len..].to_vec()
}

fn signed(data: &[u8]) -> i64 {
    let start = if data.first().is_some_and(|byte| byte & 0x80 != 0) {
        -1
    } else {
        0
    };
    data.iter()
        .fold(start, |value, byte| value << 8 | i64::from(*byte))
}

impl ServoDrive {
    fn status(&self) -> u8 {
        let moves = u8::from(self.goes_to.is_some());
        moves | u8::from(!self.is_on) << 1 | self.alarm << 2 | moves << 5
    }

    fn can_move(&self) -> bool {
        self.is_on && self.alarm == 0
    }

    fn target(&self) -> i64 {
        self.goes_to.unwrap_or(self.position)
    }

    /// A trigger of this kind; whether something starts.
    fn trigger(&mut self, kind: usize, keeps_load: bool) -> bool {
        let load = match keeps_load {
            true => self.loaded[kind],
            false => self.loaded[kind].take(),
        };
        let Some(value) = load.filter(|_| self.can_move()) else {
            return false;
        };
        self.goes_to = Some(if kind == 0 {
            value
        } else {
            self.target() + value
        });
        true
    }

    /// Goes on by itself for so long.
    fn go(&mut self, passed_us: u64) {
        let Some(target) = self.goes_to else { return };
        let most = OWN_SPEED * passed_us as i64 / 1_000 + 1;
        self.position += (target - self.position).clamp(-most, most);
        if self.position == target {
            self.goes_to = None;
        }
    }

    /// Moved by something else than the master.
    fn disturb(&mut self) {
        self.disturbances += 1;
    }

    /// The payload of an answer.
    fn obey(&mut self, now_us: u64, function: u16, data: &[u8]) -> Option<Vec<u8>> {
        match (function, data) {
            (GO_TO, _) if self.can_move() => self.goes_to = Some(signed(data)),
            (GO_BY, _) if self.can_move() => self.goes_to = Some(self.target() + signed(data)),
            (LOAD_TO, _) if self.can_move() => self.loaded[0] = Some(signed(data)),
            (LOAD_BY, _) if self.can_move() => self.loaded[1] = Some(signed(data)),
            (GO_TO | GO_BY | LOAD_TO | LOAD_BY, _) => self.disturb(),
            (STEP, _) if self.can_move() => {
                let step = signed(data);
                self.position += step;
                if step != 0 {
                    self.turns_until_us = now_us + 2_000;
                }
            }
            (STEP, _) => self.disturb(),
            (SERVO_DISABLE, [0x00]) if self.alarm == 0 => self.is_on = true,
            (SERVO_DISABLE, [0xFF]) => (self.is_on, self.goes_to) = (false, None),
            (SET_ORIGIN, _) => {
                self.position = 0;
                self.disturb();
            }
            (0x11, [speed, acceleration]) => self.group2 = [*speed, *acceleration],
            (DRIVE_RESET, _) => {
                (self.alarm, self.position, self.is_on) = (0, 0, true);
                (self.goes_to, self.loaded) = (None, [None; 2]);
                self.disturb();
            }
            (READ_CONFIG, _) => return Some(vec![0]),
            (READ_ID, _) => return Some(vec![1]),
            (READ_STATUS, _) => return Some(vec![self.status()]),
            (GENERAL_READ, [0x1B]) => {
                self.told_at = self.disturbances;
                return Some(number(self.position));
            }
            (GENERAL_READ, _) => return Some(vec![0]),
            (READ_GROUP2, _) => return Some(self.group2.to_vec()),
            (READ_GROUP3, _) => return Some(vec![20, 0, 0, 0x10, 0xC4, 0x09]),
            (READ_SPEED, _) => {
                let turns = now_us < self.turns_until_us || self.goes_to.is_some();
                let speed: i16 = if turns { 30 } else { 0 };
                return Some(speed.to_be_bytes().to_vec());
            }
            (ECHO, _) => return Some(data.to_vec()),
            (COUNTER, _) => {
                self.counter = self.counter.wrapping_add(1);
                return Some(vec![self.counter]);
            }
            _ => {}
        }
        None
    }
}

fn any_limits(random: &mut Rng) -> Limits {
    let max_step = random.i32(1..=300);
    let change = random.u32(1..=30).min(max_step as u32);
    let travel = Travel {
        min_counts: -random.i32(500..=20_000),
        max_counts: random.i32(500..=20_000),
    };
    Limits::new(
        StepLimit::new(max_step).expect("a step"),
        StepChange::from_counts(change).expect("a change of step"),
        travel,
    )
}

fn any_reaction(random: &mut Rng) -> Reaction {
    match random.u8(..4) {
        0 => Reaction::Disable,
        1 => Reaction::RampDown,
        _ => Reaction::Halt,
    }
}

impl Subject for Servos {
    type Family = Dyn;

    fn draw(random: &mut Rng) -> Self {
        let config = MasterConfig {
            timeouts: Timeouts {
                power_on_us: 5_000,
                reply_us: 4_000,
                settle_us: 500,
                alarm_quiet_us: 2_000,
                arrival_us: 40_000,
                standstill_us: 8_000,
                standstill_limit_us: 200_000,
                confirm_us: 15_000,
                ..Timeouts::DEFAULT
            },
            ..MasterConfig::DEFAULT
        };
        let axes = (1..).zip(GROUP_OF).map(|(drive, group)| {
            let drive = DriveId::new(drive).expect("a drive id");
            let gear = GearNumber::new(4_096).expect("a gear number");
            let limits = any_limits(random);
            let mut axis = AxisConfig::new(drive, gear, limits);
            axis.group = GroupId(group);
            axis.drive_curve = Some(dyn_can::ParamGroup2 {
                max_speed: dyn_can::MaxSpeed::new(5).expect("a speed"),
                max_acceleration: dyn_can::MaxAcceleration::new(5).expect("an acceleration"),
            });
            axis.wear = WearLimits {
                budget: 1_000,
                interval_us: 1_000,
            };
            axis.reactions = Reactions {
                alarm: if random.bool() {
                    Reaction::Halt
                } else {
                    Reaction::Disable
                },
                lost: any_reaction(random),
                ..Reactions::DEFAULT
            };
            axis
        });
        let axes: Vec<_> = axes.take(AXES).collect();
        let drives = axes.iter().map(|_| ServoDrive {
            is_on: random.bool(),
            alarm: 0,
            position: random.i64(-300..=300),
            disturbances: 0,
            told_at: 0,
            anchored_at: 0,
            turns_until_us: 0,
            silent_until_us: 0,
            group2: [5, 5],
            counter: 0,
            goes_to: None,
            loaded: [None; 2],
        });
        let drives = drives.collect();
        Self {
            config,
            axes,
            drives,
            loses_answers: random.bool(),
            keeps_loads: random.bool(),
            triggered: [false; AXES],
            passed_us: None,
        }
    }

    fn master(&self) -> Master<AXES, Dyn> {
        Master::new(self.config, &self.axes).expect("a configuration that works")
    }

    fn rules(&self) -> Rules {
        let axes: Vec<_> = self
            .axes
            .iter()
            .map(|axis| {
                let limits = &axis.limits;
                let max_step = i32::from(limits.max_step.get());
                let change = limits.max_step_change.per_256_cycles() as i32;
                AxisRules {
                    min: limits.travel.min_counts,
                    max: limits.travel.max_counts,
                    max_step,
                    ramp_cycles: max_step * 256 / change + 1,
                }
            })
            .collect();
        let timeouts = &self.config.timeouts;
        Rules {
            cycle_us: u64::from(self.config.cycle_us),
            stuck_us: u64::from(timeouts.stuck_us),
            confirm_us: u64::from(timeouts.confirm_us),
            reply_us: u64::from(timeouts.reply_us),
            standstill_us: u64::from(timeouts.standstill_us),
            requests_per_cycle: i32::from(self.config.requests_per_cycle),
            groups: GROUP_OF,
            axes: [axes[0], axes[1], axes[2]],
            asks_one_at_a_time: true,
            is_asked: true,
            is_absolute: false,
            has_cycle_frames: false,
            anchors_after_enable: true,
            is_speed: false,
            alarm_frees_shaft: true,
        }
    }

    fn axis_of(frame: &DataFrame) -> Option<usize> {
        usize::from(frame.id() >> 5)
            .checked_sub(1)
            .filter(|axis| *axis < AXES)
    }

    fn command(&self, frame: &DataFrame) -> Command {
        match (frame.id() & 0x1F, frame.data()) {
            (TRIGGER, _) if frame.id() == TRIGGER => Command::Trigger,
            (GO_TO, data) => Command::Go(signed(data) as i32),
            (GO_BY, data) => Command::GoBy(signed(data) as i32),
            (LOAD_TO, data) => Command::Load(signed(data) as i32),
            (LOAD_BY, data) => Command::LoadBy(signed(data) as i32),
            (STEP, data) => Command::Step(signed(data) as i32),
            (SERVO_DISABLE, [0x00]) => Command::On,
            (SERVO_DISABLE, _) => Command::Off,
            (function, _) if CHANGES.contains(&function) => Command::Change,
            _ => Command::Ask,
        }
    }

    fn told(&self, frame: &DataFrame) -> Told {
        match (frame.id() & 0x1F, frame.data()) {
            (READ_STATUS, [status]) => Told {
                power: Some(status & 2 == 0),
                ..Told::default()
            },
            (READ_SPEED, data) => Told {
                stands: Some(signed(data) == 0),
                ..Told::default()
            },
            (GENERAL_READ, data) => Told {
                position: Some(signed(data) as i32),
                ..Told::default()
            },
            (DRIVE_ERROR, [0xEE]) => Told {
                is_alarm: true,
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
        if frame.id() == TRIGGER {
            let kind = usize::from(frame.data() != [0xFF]);
            for (drive, started) in self.drives.iter_mut().zip(&mut self.triggered) {
                if now_us < drive.silent_until_us {
                    drive.disturb();
                } else {
                    *started = drive.trigger(kind, self.keeps_loads);
                }
            }
            return;
        }
        let Some(drive) = Self::axis_of(frame).and_then(|axis| self.drives.get_mut(axis)) else {
            return;
        };
        if now_us < drive.silent_until_us {
            drive.disturb();
            return;
        }
        let Some(data) = drive.obey(now_us, frame.id() & 0x1F, frame.data()) else {
            return;
        };
        let frame = DataFrame::new(frame.id(), &data).expect("an answer");
        let rare = self.loses_answers && random.u8(..) == 0;
        let late_us = if rare {
            random.u64(3_000..15_000)
        } else {
            random.u64(50..800)
        };
        let answer = Answer {
            due_us: now_us + late_us,
            frame,
            asked: Some(asked),
        };
        match random.u16(..2_000) {
            0 if self.loses_answers => {}
            1 => answers.extend([
                answer,
                Answer {
                    asked: None,
                    ..answer
                },
            ]),
            _ => answers.push(answer),
        }
    }

    fn pass(&mut self, now_us: u64, _: &mut Rng, _: &mut Vec<Answer>) {
        let before = self.passed_us.replace(now_us).unwrap_or(now_us);
        for drive in &mut self.drives {
            drive.go(now_us - before);
        }
    }

    fn disturb(
        &mut self,
        axis: usize,
        now_us: u64,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    ) -> &'static str {
        let id = (axis as u16 + 1) << 5 | DRIVE_ERROR;
        let drive = &mut self.drives[axis];
        let says = |byte: u8| Answer {
            due_us: now_us,
            frame: DataFrame::new(id, &[byte]).expect("an error"),
            asked: None,
        };
        drive.disturb();
        match random.u8(..8) {
            0 => {
                (drive.is_on, drive.position, drive.counter) = (true, 0, 0);
                (drive.goes_to, drive.loaded) = (None, [None; 2]);
                drive.silent_until_us = now_us + random.u64(0..20_000);
                "reboots"
            }
            1 => {
                (drive.alarm, drive.is_on) = (random.u8(1..=7), false);
                drive.goes_to = None;
                answers.push(says(0xEE));
                "alarms"
            }
            2 => {
                drive.alarm = 0;
                "loses its alarm"
            }
            3 => {
                drive.silent_until_us = now_us + random.u64(1_000..100_000);
                "falls silent"
            }
            4 => {
                drive.is_on = drive.alarm == 0;
                "is switched on by somebody else"
            }
            5 => {
                (drive.is_on, drive.goes_to) = (false, None);
                "is switched off by somebody else"
            }
            6 => {
                drive.position += if drive.is_on { 0 } else { random.i64(-50..=50) };
                drive.turns_until_us = now_us + random.u64(1_000..30_000);
                "is turned by hand"
            }
            _ => {
                answers.push(says(if random.bool() {
                    0xFF
                } else {
                    random.u8(..0xEE)
                }));
                "reports an error"
            }
        }
    }

    fn seen(&self, axis: usize, kind: &EventKind) -> Seen {
        match kind {
            EventKind::Fault(fault) => Seen::Fault {
                is_own: *fault != Fault::Group,
                is_bus: matches!(fault, Fault::Bus | Fault::Lost),
                ramps: self.axes[axis].reactions.to(*fault) == Reaction::RampDown,
                ramps_itself: false,
                disables: self.axes[axis].reactions.to(*fault) == Reaction::Disable,
            },
            EventKind::State { from, to, reason } => Seen::State {
                from: *from,
                to: *to,
                by_fault: *reason == can_motion::Reason::Fault,
                is_back: *reason == can_motion::Reason::Displaced,
            },
            _ => Seen::Other,
        }
    }

    const HAS_MOVES: bool = true;

    fn triggered(&mut self) -> [bool; AXES] {
        std::mem::take(&mut self.triggered)
    }

    fn procedure(random: &mut Rng) -> Option<(Procedure, Confirmation)> {
        let confirmation = if random.bool() {
            Confirmation::Given
        } else {
            Confirmation::None
        };
        let group2 = SetParamGroup2 {
            max_speed: dyn_can::MaxSpeed::new(random.i32(1..=127)).ok(),
            max_acceleration: dyn_can::MaxAcceleration::new(30).ok(),
        };
        let procedure = match random.u8(..5) {
            0 => Procedure::SetOrigin,
            1 => Procedure::DriveReset,
            2 => Procedure::WriteGroup2(group2),
            3 => Procedure::ReadDriveId,
            _ => Procedure::ReadGroup3,
        };
        Some((procedure, confirmation))
    }

    fn sent(snapshot: &AxisSnapshot) -> i32 {
        snapshot.sent_counts
    }

    fn undisturbed_position(&self, axis: usize) -> Option<i64> {
        let drive = &self.drives[axis];
        (drive.is_on && drive.disturbances == drive.anchored_at).then_some(drive.position)
    }

    fn anchored(&mut self, axis: usize) {
        let drive = &mut self.drives[axis];
        drive.anchored_at = drive.told_at;
    }
}
