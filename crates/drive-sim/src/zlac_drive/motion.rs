//! The wheel of one drive in lazy time.
//!
//! Specification: time is cut into ticks of [`TICK_NS`]; speed changes by at most the acceleration in force, and looking changes nothing.
//! Positions are in counts, four a line; speeds in counts a second.

use super::config::ZlacDriveConfig;
use super::mechanics::{Gains, Loops, ZlacLoop, ZlacMechanics};
use super::memory::Memory;
use super::objects;
use super::power_stage::{PowerStage, Stage};

/// Length of a tick.
pub(super) const TICK_NS: u64 = 250_000;
const TICK_S: f64 = TICK_NS as f64 * 1e-9;
const MS_PER_S: f64 = 1_000.0;
const S_PER_MIN: f64 = 60.0;

/// What the motor tries to do.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Goal {
    /// Power stage off, or the shaft released.
    Free,
    /// Power stage off and the phases short-circuited (202Fh:01).
    Shorted,
    /// A speed, reached with the accelerations in force.
    Speed { target: f64 },
    /// A position with a profile.
    Position { target: f64, speed: f64 },
    /// A current; it accelerates the wheel, friction brakes it.
    Torque { ma: f64 },
}

/// How the wheel comes to a stop (605Ah, 605Dh).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Braking {
    /// "Stop normally": the deceleration time 6084h.
    Normal,
    /// "Decelerate suddenly": the emergency stop deceleration time 6085h.
    Emergency,
    /// "Emergency stop": what the motor can, the current limit of CiA 402.
    AsFastAsItCan,
}

impl Braking {
    fn of_quick_stop(option: u32) -> Self {
        match option {
            6 => Self::Emergency,
            7 => Self::AsFastAsItCan,
            _ => Self::Normal,
        }
    }

    /// The default 1 is in no list of the guide; in CiA 402 it is the normal stop (Z27).
    fn of_halt(option: u32) -> Self {
        match option {
            2 => Self::Emergency,
            3 => Self::AsFastAsItCan,
            _ => Self::Normal,
        }
    }
}

/// Reference and wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    ticks: u64,
    position: f64,
    speed: f64,
    goal: Goal,
    acceleration: f64,
    deceleration: f64,
    motor_acceleration: f64,
    coast: f64,
    counts_per_turn: f64,
    /// n of the speed resolution in force since power-on.
    resolution: f64,
    /// Where the wheel stands when the drive reports 0.
    origin: f64,
    /// 1 where the drive counts clockwise turns up, -1 where it counts them down (2001h).
    direction: f64,
    /// Where the shaft stood when the direction came into force, clockwise up, and where the drive counted it then.
    turned_at: (f64, f64),
    /// Of the latest tick.
    accelerated: f64,
    /// In torque mode; the slope brings it to the target.
    current_ma: f64,
    /// mA a second; 0: at once.
    slope_ma_s: f64,
    /// The holding brake is closed.
    braked: bool,
    /// Current limit of the parking mode.
    parking_ma: f64,
    /// The same and 2015h: the limit of torque mode, and of what pushes against a stop. An acceleration is not limited by 2015h.
    most_ma: f64,
    start_stop: f64,
    set_point: Option<f64>,
    acknowledged: bool,
    mode: i8,
    rpm_s: Rates,
    mechanics: ZlacMechanics,
    gains: Gains,
    loops: Loops,
    /// Current against a stop, in mA; 0 where the wheel is free.
    pushed_ma: f64,
}

/// What the mechanics do, in r/min a second.
#[derive(Debug, Clone, Copy)]
struct Rates {
    motor: f64,
    coast: f64,
    shorted: f64,
    brake: f64,
}

/// What an emergency stop input does while it is active (202Fh:03).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EmergencyInput {
    /// The wheel stops and is held.
    Holds,
    /// The shaft is released.
    Releases,
}

const MA_PER_DECIAMPERE: f64 = 100.0;
/// The motor's current in parking mode is at most this (guide section 5.2).
const PARKING_MA: f64 = 3_000.0;

impl Motion {
    pub(super) fn new(config: &ZlacDriveConfig) -> Self {
        Self {
            ticks: 0,
            position: 0.0,
            speed: 0.0,
            goal: Goal::Free,
            acceleration: 0.0,
            deceleration: 0.0,
            motor_acceleration: 0.0,
            coast: 0.0,
            counts_per_turn: 1.0,
            resolution: 1.0,
            origin: 0.0,
            direction: 1.0,
            turned_at: (0.0, 0.0),
            accelerated: 0.0,
            current_ma: 0.0,
            slope_ma_s: 0.0,
            braked: false,
            parking_ma: f64::INFINITY,
            most_ma: f64::INFINITY,
            start_stop: 0.0,
            set_point: None,
            acknowledged: false,
            mode: 0,
            rpm_s: Rates {
                motor: config.motor_acceleration_rpm_s,
                coast: config.coast_deceleration_rpm_s,
                shorted: config.shorted_deceleration_rpm_s,
                brake: config.brake_deceleration_rpm_s,
            },
            mechanics: config.mechanics,
            gains: Gains::of(0, 0, 0),
            loops: Loops::default(),
            pushed_ma: 0.0,
        }
    }

    /// Takes over what changes at power-on only; the encoder is incremental, so the position is 0.
    pub(super) fn power_on(&mut self, memory: &Memory) {
        self.counts_per_turn = f64::from(memory.get(objects::ENCODER_LINES).max(1)) * 4.0;
        self.resolution = f64::from(memory.get(objects::SPEED_RESOLUTION).max(1));
        self.motor_acceleration = self.counts_s(self.rpm_s.motor);
        self.coast = self.counts_s(self.rpm_s.coast);
        self.origin = self.position;
        self.set_point = None;
        self.mode = 0;
    }

    fn counts_s(&self, rpm: f64) -> f64 {
        rpm * self.counts_per_turn / S_PER_MIN
    }

    pub(super) fn advance_to(&mut self, at_ns: u64) {
        let until = at_ns / TICK_NS;
        while self.ticks < until && !self.at_rest() {
            self.tick();
            self.ticks += 1;
        }
        self.ticks = self.ticks.max(until);
    }

    /// Nothing changes until the next command.
    pub(super) fn at_rest(&self) -> bool {
        self.speed == 0.0
            && match self.goal {
                Goal::Free | Goal::Shorted => true,
                // A closed brake holds the wheel against everything.
                Goal::Speed { .. } | Goal::Position { .. } if self.braked => true,
                Goal::Speed { target } => target == 0.0 && self.has_settled(),
                Goal::Position { target, .. } => target == self.position,
                Goal::Torque { ma } => ma == self.current_ma && (ma == 0.0 || self.braked),
            }
    }

    /// No loop has anything left to do.
    fn has_settled(&self) -> bool {
        self.mechanics.control == ZlacLoop::Ideal || self.loops == Loops::at(self.position, 0.0)
    }

    fn tick(&mut self) {
        let before = self.speed;
        self.follow_slope();
        let follows = matches!(self.goal, Goal::Speed { .. } | Goal::Position { .. });
        if self.braked {
            self.approach(0.0, self.counts_s(self.rpm_s.brake));
        } else if follows && self.mechanics.control == ZlacLoop::WithGains {
            self.follow_profile();
        } else {
            self.move_on();
        }
        if self.braked || !follows {
            self.loops = Loops::at(self.position, self.speed);
        }
        self.meet_stops();
        self.accelerated = (self.speed - before) / TICK_S;
    }

    /// The current of torque mode changes by the slope.
    fn follow_slope(&mut self) {
        let Goal::Torque { ma } = self.goal else {
            self.current_ma = 0.0;
            return;
        };
        let most = if self.slope_ma_s == 0.0 {
            f64::INFINITY
        } else {
            self.slope_ma_s * TICK_S
        };
        self.current_ma += (ma - self.current_ma).clamp(-most, most);
    }

    fn move_on(&mut self) {
        match self.goal {
            Goal::Free => self.approach(0.0, self.coast),
            Goal::Shorted => self.approach(0.0, self.counts_s(self.rpm_s.shorted)),
            Goal::Speed { target } => self.approach(target, self.rate_to(target)),
            Goal::Position { target, speed } => self.approach_position(target, speed),
            Goal::Torque { .. } => {
                let drive = self.acceleration_by(self.current_ma);
                let friction = self.coast.min(self.speed.abs() / TICK_S) * self.speed.signum();
                self.speed += (drive - friction) * TICK_S;
                self.position += self.speed * TICK_S;
            }
        }
    }

    /// The profile goes on, and the loops bring the wheel behind it.
    fn follow_profile(&mut self) {
        let (wheel, profile) = ((self.position, self.speed), self.loops);
        (self.position, self.speed) = (profile.position, profile.speed);
        self.move_on();
        (self.loops.position, self.loops.speed) = (self.position, self.speed);
        (self.position, self.speed) = wheel;
        let is_position = matches!(self.goal, Goal::Position { .. });
        let most = self.motor_acceleration;
        let wanted = self
            .loops
            .acceleration(&self.gains, wheel, is_position, TICK_S);
        let before = self.speed;
        self.speed += wanted.clamp(-most, most) * TICK_S;
        self.position += (before + self.speed) / 2.0 * TICK_S;
        if self
            .loops
            .is_settled((self.position, self.speed), is_position)
        {
            let place = if is_position {
                self.loops.position
            } else {
                self.position
            };
            (self.position, self.speed) = (place, 0.0);
            self.loops = Loops::at(place, 0.0);
        }
    }

    /// A wheel that has come to a stop stays there, and its motor pushes.
    fn meet_stops(&mut self) {
        let Some(place) = self.mechanics.passed(self.shaft_turns()) else {
            self.pushed_ma = 0.0;
            return;
        };
        let outward = (self.shaft_turns() - place).signum() * self.direction;
        let (shaft, position) = self.turned_at;
        self.position = position + self.direction * (place * self.counts_per_turn - shaft);
        self.speed = 0.0;
        let pushed = match self.goal {
            Goal::Position { target, .. } => {
                let degrees = (target - self.position) * outward / self.counts_per_turn * 360.0;
                degrees * self.mechanics.push_ma_per_degree
            }
            Goal::Speed { target } if target * outward > 0.0 => {
                self.pushed_ma.abs() + self.mechanics.stall_ma_per_s * TICK_S
            }
            _ => 0.0,
        };
        self.pushed_ma = outward * pushed.clamp(0.0, self.most_ma);
    }

    /// 1 A accelerates the unloaded wheel twice as much as friction brakes it.
    fn acceleration_by(&self, ma: f64) -> f64 {
        ma / MS_PER_S * 2.0 * self.coast
    }

    fn approach_position(&mut self, target: f64, speed: f64) {
        let distance = target - self.position;
        let braking = (2.0 * self.deceleration * distance.abs()).sqrt();
        // Half a tick's way is arrival: the profile cannot be finer.
        if distance.abs() <= 0.5 || distance.abs() <= self.deceleration * TICK_S * TICK_S {
            self.position = target;
            self.speed = 0.0;
            return;
        }
        // The move begins and ends with the start/stop speed (6082h).
        let slowest = self.start_stop.min(speed);
        let wanted =
            distance.signum() * braking.max(slowest).min(speed).min(distance.abs() / TICK_S);
        if self.speed.abs() < slowest && self.speed * wanted >= 0.0 {
            self.speed = wanted.signum() * slowest.min(wanted.abs());
        }
        self.approach(wanted, self.rate_to(wanted).max(self.deceleration * 1.1));
    }

    fn approach(&mut self, wanted: f64, rate: f64) {
        let change = (wanted - self.speed).clamp(-rate * TICK_S, rate * TICK_S);
        let before = self.speed;
        self.speed += change;
        self.position += (before + self.speed) / 2.0 * TICK_S;
    }

    fn rate_to(&self, wanted: f64) -> f64 {
        let slower = wanted.abs() < self.speed.abs() || wanted * self.speed < 0.0;
        let rate = if slower {
            self.deceleration
        } else {
            self.acceleration
        };
        // Friction takes its part of what a limited current can do.
        rate.min(self.acceleration_by(self.parking_ma) - self.coast)
    }

    pub(super) fn release(&mut self) {
        self.goal = Goal::Free;
    }

    /// An acceleration that takes a time from standstill to the largest speed; 0 is as fast as the motor can.
    fn ramp(&self, memory: &Memory, time_ms: u32) -> f64 {
        let top = self.counts_s(f64::from(memory.get(objects::MAX_SPEED)));
        match time_ms {
            0 => self.motor_acceleration,
            ms => (top * MS_PER_S / f64::from(ms)).min(self.motor_acceleration),
        }
    }

    pub(super) fn drive(
        &mut self,
        stage: &PowerStage,
        input: Option<EmergencyInput>,
        memory: &Memory,
    ) {
        self.take_settings(stage, memory);
        self.acceleration = self.ramp(memory, memory.get(objects::ACCELERATION_TIME));
        let enabled = stage.stage() == Stage::Enabled;
        let braking = if input.is_some() {
            Some(Braking::Emergency)
        } else if stage.stage() == Stage::QuickStop {
            Some(Braking::of_quick_stop(
                memory.get(objects::QUICK_STOP_OPTION),
            ))
        } else if enabled && stage.halted() {
            Some(Braking::of_halt(memory.get(objects::HALT_OPTION)))
        } else {
            None
        };
        let time_ms = match braking {
            Some(Braking::Emergency) => memory.get(objects::EMERGENCY_TIME),
            Some(Braking::AsFastAsItCan) => 0,
            Some(Braking::Normal) | None => memory.get(objects::DECELERATION_TIME),
        };
        self.deceleration = self.ramp(memory, time_ms);
        let stops = braking.is_some() || stage.is_leaving();
        self.goal = match stage.stage() {
            Stage::Enabled | Stage::QuickStop if input == Some(EmergencyInput::Releases) => {
                self.set_point = None;
                Goal::Free
            }
            Stage::Enabled if stops => Goal::Speed { target: 0.0 },
            Stage::Enabled => self.enabled_goal(memory),
            Stage::QuickStop => Goal::Speed { target: 0.0 },
            Stage::Off | Stage::Ready | Stage::SwitchedOn | Stage::Fault => {
                self.set_point = None;
                let is_shorted =
                    stage.stage() == Stage::Fault && memory.get(objects::ALARM_PWM) == 1;
                if is_shorted {
                    Goal::Shorted
                } else {
                    Goal::Free
                }
            }
        };
    }

    /// Settings that count at once; the direction waits until nothing is energised, so that no wheel jerks.
    fn take_settings(&mut self, stage: &PowerStage, memory: &Memory) {
        self.braked = memory.get(objects::HOLDING_BRAKE) == 1;
        self.slope_ma_s = f64::from(memory.get(objects::TORQUE_SLOPE));
        self.start_stop = self.counts_s(f64::from(memory.get(objects::START_STOP_SPEED)));
        self.gains = Gains::of(
            memory.get(objects::SPEED_KP),
            memory.get(objects::SPEED_KI),
            memory.get(objects::POSITION_KP),
        );
        self.parking_ma = if memory.get(objects::PARKING) == 1 {
            PARKING_MA
        } else {
            f64::INFINITY
        };
        let most_ma = f64::from(memory.get(objects::MAX_CURRENT)) * MA_PER_DECIAMPERE;
        self.most_ma = most_ma.min(self.parking_ma);
        let direction = if memory.get(objects::ROTATION) == 1 {
            -1.0
        } else {
            1.0
        };
        let is_energised = matches!(stage.stage(), Stage::Enabled | Stage::QuickStop);
        if direction != self.direction && !is_energised {
            self.turned_at = (self.shaft(), self.position);
            self.direction = direction;
            self.speed = -self.speed;
        }
    }

    /// Where the shaft is, clockwise up.
    fn shaft(&self) -> f64 {
        let (shaft, position) = self.turned_at;
        shaft + self.direction * (self.position - position)
    }

    pub(super) fn stands(&self) -> bool {
        self.speed == 0.0
    }

    fn enabled_goal(&self, memory: &Memory) -> Goal {
        match self.mode {
            1 => match self.set_point {
                Some(target) => Goal::Position {
                    target,
                    speed: self
                        .counts_s(f64::from(memory.get(objects::PROFILE_SPEED)))
                        .min(self.fastest(memory)),
                },
                None => Goal::Speed { target: 0.0 },
            },
            3 => {
                let rpm = f64::from(memory.signed(objects::TARGET_SPEED)) / self.resolution;
                let fastest = self.fastest(memory);
                Goal::Speed {
                    target: self.counts_s(rpm).clamp(-fastest, fastest),
                }
            }
            4 => Goal::Torque {
                // The lower 16 bits are the object.
                ma: f64::from(memory.get(objects::TARGET_TORQUE) as i16)
                    .clamp(-self.most_ma, self.most_ma),
            },
            _ => Goal::Speed { target: 0.0 },
        }
    }

    /// 200Ah.
    fn fastest(&self, memory: &Memory) -> f64 {
        self.counts_s(f64::from(memory.get(objects::MAX_SPEED)))
    }

    pub(super) fn set_mode(&mut self, mode: i8) {
        self.mode = mode;
        self.set_point = None;
    }

    pub(super) fn mode(&self) -> i8 {
        self.mode
    }

    pub(super) fn new_set_point(&mut self, relative: bool, memory: &Memory) {
        let counts = f64::from(memory.signed(objects::TARGET_POSITION));
        let from = if relative { self.position } else { self.origin };
        self.set_point = (self.mode == 1).then_some((from + counts).round());
    }

    pub(super) fn set_acknowledged(&mut self, acknowledged: bool) {
        self.acknowledged = acknowledged && self.set_point.is_some();
    }

    pub(super) fn clear_position(&mut self) {
        self.origin = self.position;
    }

    /// Position as reported.
    pub(super) fn counts(&self) -> i64 {
        (self.position - self.origin).round() as i64
    }

    /// Distance of the shaft from where it stood at 0 ns, clockwise up; nothing changes it but motion.
    pub(super) fn travel_counts(&self) -> i64 {
        self.shaft().round() as i64
    }

    pub(super) fn shaft_turns(&self) -> f64 {
        self.shaft() / self.counts_per_turn
    }

    /// The switch beside the shaft is operated.
    pub(super) fn switch_is_operated(&self) -> bool {
        self.mechanics.is_operated(self.shaft_turns())
    }

    pub(super) fn shaft_rpm(&self) -> f64 {
        self.direction * self.speed_rpm()
    }

    /// It stands where its move should end.
    pub(super) fn has_arrived(&self) -> bool {
        matches!(self.goal, Goal::Position { target, .. } if target == self.position)
    }

    pub(super) fn speed_rpm(&self) -> f64 {
        self.speed / self.counts_per_turn * S_PER_MIN
    }

    pub(super) fn counts_per_turn(&self) -> f64 {
        self.counts_per_turn
    }

    /// Bits 10, 12 and 14 of the status word.
    pub(super) fn status_bits(&self) -> u16 {
        let reached = match self.goal {
            Goal::Free | Goal::Shorted => false,
            Goal::Speed { target } => (self.speed - target).abs() < 1e-6,
            Goal::Position { target, .. } => target == self.position,
            Goal::Torque { ma } => ma == self.current_ma,
        };
        let bit_12 = match self.mode {
            1 => self.acknowledged,
            3 => self.speed == 0.0,
            _ => false,
        };
        u16::from(reached) << 10 | u16::from(bit_12) << 12 | u16::from(self.speed != 0.0) << 14
    }

    /// Current in mA: in torque mode what the slope has reached, in the others what acceleration and friction take.
    pub(super) fn current_ma(&self) -> f64 {
        match self.goal {
            Goal::Torque { .. } => self.current_ma,
            Goal::Free | Goal::Shorted => 0.0,
            Goal::Speed { target } if self.pushed_ma != 0.0 && target != 0.0 => self.pushed_ma,
            Goal::Position { target, .. } if self.pushed_ma != 0.0 && target != self.position => {
                self.pushed_ma
            }
            Goal::Speed { .. } | Goal::Position { .. } if self.speed == 0.0 || self.braked => 0.0,
            Goal::Speed { .. } | Goal::Position { .. } => {
                let force = self.accelerated + self.coast * self.speed.signum();
                force / self.acceleration_by(1.0)
            }
        }
    }

    /// What the drive tries to bring the current to, in mA.
    pub(super) fn demand_ma(&self) -> f64 {
        match self.goal {
            Goal::Torque { ma } => ma,
            _ => self.current_ma(),
        }
    }

    /// The same motion at `at_ns`, if nothing happens until then.
    pub(super) fn at(mut self, at_ns: u64) -> Self {
        self.advance_to(at_ns);
        self
    }
}
