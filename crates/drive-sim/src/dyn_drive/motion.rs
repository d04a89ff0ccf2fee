//! Reference and motor of one drive in lazy time.
//!
//! Specification: time is cut into ticks of [`TICK_NS`]; a command changes the state between two ticks, and reading changes nothing. So the motion
//! is the same however often somebody looks, and a motor at rest costs nothing.

use super::reference::{Generator, Wave};
use super::servo::{Limits, Motor, TICK_NS, TICK_S};

/// Shares of acceleration and of following error in the torque.
const TORQUE_SHARES: (f64, f64) = (0.75, 0.25);

/// Reference and motor. Positions count from where the shaft stood when the drive was made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    ticks: u64,
    reference: f64,
    generator: Generator,
    motor: Motor,
    limits: Limits,
    /// The motor rests where it shall, so that nothing changes until the next command.
    at_rest: bool,
    /// The following error went beyond its limit.
    tripped: bool,
}

impl Motion {
    pub(super) fn new(limits: Limits) -> Self {
        Self {
            ticks: 0,
            reference: 0.0,
            generator: Generator::Free,
            motor: Motor::default(),
            limits,
            at_rest: true,
            tripped: false,
        }
    }

    /// Lets time pass until `at_ns`; an instant in the past changes nothing.
    pub(super) fn advance_to(&mut self, at_ns: u64) {
        let until = at_ns / TICK_NS;
        while self.ticks < until && !self.at_rest {
            self.tick();
            self.ticks += 1;
        }
        self.ticks = self.ticks.max(until);
    }

    fn tick(&mut self) {
        match self.generator {
            Generator::Free => {
                self.motor.coast(&self.limits);
                self.reference = self.motor.position;
                self.at_rest = self.motor.velocity == 0.0;
            }
            Generator::Speed { velocity, ramp } => {
                self.motor.ramp_to(velocity, ramp, &self.limits);
                self.reference = self.motor.position;
                self.at_rest = velocity == 0.0 && self.motor.velocity == 0.0;
            }
            Generator::Hold | Generator::Profile { .. } | Generator::Wave { .. } => {
                self.generator.advance(&mut self.reference, &self.limits);
                self.motor.follow(self.reference, &self.limits);
                self.check_error();
            }
        }
    }

    fn check_error(&mut self) {
        let beyond = self
            .limits
            .lost_phase
            .is_some_and(|limit| self.error().abs() > limit);
        if beyond {
            self.tripped = true;
            self.release();
        } else if self.generator == Generator::Hold {
            self.at_rest = self.motor.settle(self.reference, &self.limits);
        }
    }

    /// The same motion at `at_ns`, if nothing happens until then.
    pub(super) fn at(mut self, at_ns: u64) -> Self {
        self.advance_to(at_ns);
        // Between two ticks the shaft goes on at its speed; an instant before the last tick is not known any more.
        let since_s = at_ns.saturating_sub(self.ticks * TICK_NS) as f64 * 1e-9;
        self.motor.position += self.motor.velocity * since_s;
        if let Some(stops) = &self.limits.stops {
            self.motor.position = stops.hold(self.motor.position);
        }
        if self.is_free() || matches!(self.generator, Generator::Speed { .. }) {
            self.reference = self.motor.position;
        }
        self
    }

    /// Earliest instant at which the following error can be beyond its limit, as seen from the last tick.
    pub(super) fn check_due_ns(&self) -> Option<u64> {
        let limit = self.limits.lost_phase?;
        let speed_bound = self.motor.velocity.abs().max(self.limits.motor_speed);
        let reference_bound = match self.generator {
            _ if self.at_rest => return None,
            Generator::Free | Generator::Speed { .. } => return None,
            Generator::Hold => 0.0,
            Generator::Profile { velocity, .. } => velocity.abs().max(self.limits.profile_speed),
            // A square wave jumps.
            Generator::Wave { .. } => f64::INFINITY,
        };
        let margin = (limit - self.error().abs()).max(0.0);
        let safe_ticks = margin / ((speed_bound + reference_bound) * TICK_S);
        Some(
            (self.ticks + 1)
                .saturating_add(safe_ticks as u64)
                .saturating_mul(TICK_NS),
        )
    }

    /// Whether the following error went beyond its limit since the last call.
    pub(super) fn take_trip(&mut self) -> bool {
        core::mem::take(&mut self.tripped)
    }

    pub(super) fn set_limits(&mut self, limits: Limits) {
        self.at_rest &= self.limits == limits;
        self.limits = limits;
    }

    /// Switches the motor free; a position error is forgotten.
    pub(super) fn release(&mut self) {
        self.generator = Generator::Free;
        self.reference = self.motor.position;
        self.at_rest = false;
    }

    /// Holds the position where the shaft is, in whole counts.
    pub(super) fn hold(&mut self) {
        self.generator = Generator::Hold;
        self.reference = self.motor.position.round();
        self.motor.restart_loop();
        self.at_rest = false;
    }

    pub(super) fn step(&mut self, counts: i16) {
        let counts = f64::from(counts);
        self.leave_speed();
        match &mut self.generator {
            Generator::Profile { target, .. } => *target += counts,
            Generator::Wave { base, .. } => *base += counts,
            Generator::Free | Generator::Hold | Generator::Speed { .. } => {}
        }
        self.reference += counts;
        self.at_rest = false;
    }

    /// Starts a built-in move to `target`, in place of whatever runs.
    pub(super) fn go_to(&mut self, target: i64) {
        self.leave_speed();
        let velocity = match self.generator {
            Generator::Profile { velocity, .. } => velocity,
            _ => 0.0,
        };
        let target = target as f64;
        self.generator = Generator::Profile { target, velocity };
        self.at_rest = false;
    }

    /// Turns at a speed, which a soft start reaches after a time unless the motor needs longer.
    ///
    /// The manual calls the soft start an S-curve and gives its whole time, 1.2 times that from 10 to 90 %; a straight line of that
    /// whole time comes nearest to both.
    pub(super) fn turn_at(&mut self, counts_per_s: f64, soft_start_s: f64) {
        self.generator = Generator::Speed {
            velocity: counts_per_s,
            ramp: (counts_per_s - self.motor.velocity).abs() / soft_start_s,
        };
        self.at_rest = false;
    }

    pub(super) fn swing(&mut self, wave: Wave) {
        self.leave_speed();
        let base = match self.generator {
            Generator::Wave { base, .. } => base,
            _ => self.reference.round(),
        };
        self.generator = Generator::Wave {
            wave,
            base,
            ticks: 0,
        };
        self.at_rest = false;
    }

    /// Ends a wave at its base, and changes nothing else.
    pub(super) fn stop_swinging(&mut self) {
        if let Generator::Wave { base, .. } = self.generator {
            self.reference = base;
            self.generator = Generator::Hold;
            self.at_rest = false;
        }
    }

    fn leave_speed(&mut self) {
        if matches!(self.generator, Generator::Speed { .. }) {
            self.hold();
        }
    }

    /// Where the commanded motion ends, in whole counts.
    pub(super) fn target(&self) -> i64 {
        let target = match self.generator {
            Generator::Profile { target, .. } => target,
            Generator::Wave { base, .. } => base,
            Generator::Free | Generator::Hold | Generator::Speed { .. } => self.reference,
        };
        target.round() as i64
    }

    pub(super) fn position(&self) -> i64 {
        self.motor.position.round() as i64
    }

    pub(super) fn velocity(&self) -> f64 {
        self.motor.velocity
    }

    /// Commanded minus actual position in counts.
    pub(super) fn error(&self) -> f64 {
        self.reference - self.motor.position
    }

    /// Torque as a share of the peak, -1 ..= 1.
    pub(super) fn torque_share(&self, full_error_counts: f64) -> f64 {
        if self.is_free() {
            return 0.0;
        }
        let (by_acceleration, by_error) = TORQUE_SHARES;
        let acceleration = self.motor.acceleration / self.limits.motor_acceleration;
        let pressing = self.limits.stops.filter(|_| self.motor.is_pressed);
        let full_error_counts =
            pressing.map_or(full_error_counts, |stops| stops.full_torque_counts);
        let error = (self.error() / full_error_counts).clamp(-1.0, 1.0);
        if pressing.is_some() {
            return error;
        }
        (by_acceleration * acceleration + by_error * error).clamp(-1.0, 1.0)
    }

    pub(super) fn is_free(&self) -> bool {
        self.generator == Generator::Free
    }

    /// A built-in point-to-point move runs.
    pub(super) fn is_busy(&self) -> bool {
        matches!(self.generator, Generator::Profile { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::super::reference::WaveKind;
    use super::*;

    fn limits() -> Limits {
        Limits {
            profile_speed: 800_000.0,
            profile_acceleration: 10e6,
            motor_speed: 800_000.0,
            motor_acceleration: 10e6,
            coast_deceleration: 1e6,
            lost_phase: Some(8_192.0),
            stops: None,
            gains: None,
        }
    }

    fn held() -> Motion {
        let mut motion = Motion::new(limits());
        motion.hold();
        motion
    }

    #[test]
    fn looking_often_changes_nothing() {
        let play = |pause_ns: u64| {
            let mut motion = held();
            for at_ns in (0..40_000_000).step_by(pause_ns as usize) {
                motion.advance_to(at_ns);
                if at_ns % 1_000_000 == 0 && at_ns < 20_000_000 {
                    motion.step(123);
                }
            }
            motion.advance_to(39_999_999);
            (motion.motor, motion.reference)
        };
        let seldom = play(1_000_000);
        assert_eq!(seldom, play(10_000));
        assert_eq!(seldom, play(125_000));
        assert_ne!(seldom.0.velocity, 0.0);
    }

    #[test]
    fn reading_ahead_leaves_the_motion_alone() {
        let mut motion = held();
        motion.step(1_000);
        let ahead = motion.at(500_000_000);
        assert_eq!((ahead.position(), motion.position()), (1_000, 0));
    }

    #[test]
    fn error_beyond_the_limit_trips_and_frees_the_motor() {
        let mut motion = held();
        motion.step(8_192);
        motion.advance_to(100_000_000);
        assert!(!motion.take_trip());
        motion.step(9_000);
        motion.advance_to(101_000_000);
        assert!(motion.is_free());
        assert!(motion.take_trip() && !motion.take_trip());
    }

    /// A stream that stops dead: the motor overshoots by more than the limit some milliseconds later.
    fn about_to_overshoot() -> Motion {
        let mut motion = held();
        for cycle in 0..100_i16 {
            motion.advance_to(cycle as u64 * 1_000_000);
            motion.step(cycle * 8);
        }
        assert!(!motion.tripped);
        motion
    }

    #[test]
    fn trip_is_announced_to_the_tick_with_few_looks() {
        let mut watched = about_to_overshoot();
        let mut patient = watched;
        while !watched.tripped {
            watched.advance_to((watched.ticks + 1) * TICK_NS);
        }
        let mut looks = 0;
        while !patient.tripped {
            patient.advance_to(patient.check_due_ns().unwrap());
            looks += 1;
        }
        assert_eq!(patient.ticks, watched.ticks);
        assert!(looks < 10, "{looks} looks");
    }

    #[test]
    fn wave_returns_to_its_base() {
        let mut motion = held();
        motion.swing(Wave {
            kind: WaveKind::Sine,
            amplitude_counts: 500.0,
            frequency_hz: 5.0,
        });
        motion.advance_to(50_000_000);
        assert!(motion.position() > 300, "{}", motion.position());
        motion.step(10);
        motion.stop_swinging();
        motion.advance_to(500_000_000);
        assert_eq!((motion.position(), motion.at_rest), (10, true));
    }

    #[test]
    fn new_target_replaces_the_running_one() {
        let mut motion = held();
        motion.go_to(100_000);
        motion.advance_to(50_000_000);
        assert!(motion.is_busy() && motion.velocity() > 0.0);
        motion.go_to(-1_000);
        motion.advance_to(1_000_000_000);
        assert_eq!((motion.position(), motion.is_busy()), (-1_000, false));
    }
}
