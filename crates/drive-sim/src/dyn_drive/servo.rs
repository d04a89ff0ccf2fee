//! The motor with its servo loop.
//!
//! Specification: speed and acceleration never exceed their limits, and a reference that stands still is reached exactly. The loop smooths the
//! reference twice, feeds its speed forward and closes the rest with a gain that turns into a braking curve for large errors; this is
//! a plausible servo and not a model of the real one, whose loop is not published.
//!
//! That loop does not know the gains. [`Gains`](super::gains::Gains) is another one that does, for drives that are to be tuned.
//!
//! All arithmetic is in command counts and seconds, in ticks of fixed length, so that results do not depend on when somebody looks.

use super::gains::{Feedback, Gains};
use super::mechanics::Stops;

/// Length of a tick.
pub const TICK_NS: u64 = 250_000;

/// Length of a tick in seconds.
pub(super) const TICK_S: f64 = 250e-6;

/// Share of the way to the reference that each of the two smoothing stages goes in a tick: a time constant of 1 ms.
const SMOOTHING: f64 = 0.2;

/// Gain of the position loop in 1/s.
const POSITION_GAIN: f64 = 200.0;

/// Share of the acceleration limit that the braking curve uses, so that the rest can correct it.
const BRAKING_SHARE: f64 = 0.9;

/// Nearer than this the motor has arrived, in counts.
const ARRIVED_COUNTS: f64 = 0.5;

/// Limits of one axis in counts/s and counts/s2, and the error of the lost phase alarm in counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    pub(super) profile_speed: f64,
    pub(super) profile_acceleration: f64,
    pub(super) motor_speed: f64,
    pub(super) motor_acceleration: f64,
    pub(super) coast_deceleration: f64,
    pub(super) lost_phase: Option<f64>,
    /// Ends of the shaft's way.
    pub(super) stops: Option<Stops>,
    /// The loop whose answer depends on the gains.
    pub(super) gains: Option<Gains>,
}

/// Position of the shaft and state of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motor {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    smoothed: [f64; 2],
    /// State of the loop with gains.
    feedback: Feedback,
    /// The shaft stands against a stop.
    pub(super) is_pressed: bool,
}

impl Motor {
    /// The loop forgets earlier references and starts from where the shaft is.
    pub(super) fn restart_loop(&mut self) {
        self.smoothed = [self.position; 2];
        self.feedback = Feedback::default();
    }

    /// One tick towards `reference`.
    pub(super) fn follow(&mut self, reference: f64, limits: &Limits) {
        if let Some(gains) = &limits.gains {
            return self.answer(reference, gains, limits);
        }
        let [first, second] = self.smoothed;
        let first = first + (reference - first) * SMOOTHING;
        let moved = (first - second) * SMOOTHING;
        self.smoothed = [first, second + moved];
        let error = second + moved - self.position;
        let wanted = moved / TICK_S + approach_speed(error, limits.motor_acceleration);
        self.run_at(wanted, limits);
    }

    /// One tick towards a speed by a soft start.
    pub(super) fn ramp_to(&mut self, wanted: f64, ramp: f64, limits: &Limits) {
        let wanted = wanted.clamp(-limits.motor_speed, limits.motor_speed);
        self.change_speed(wanted, ramp.min(limits.motor_acceleration), limits);
    }

    /// One tick towards a speed.
    fn run_at(&mut self, wanted: f64, limits: &Limits) {
        let wanted = wanted.clamp(-limits.motor_speed, limits.motor_speed);
        self.change_speed(wanted, limits.motor_acceleration, limits);
    }

    /// One tick of the loop with gains.
    fn answer(&mut self, reference: f64, gains: &Gains, limits: &Limits) {
        let state = (self.position, self.velocity);
        let wanted = self.feedback.acceleration(reference, state, gains, limits);
        self.run_at(self.velocity + wanted * TICK_S, limits);
    }

    /// One tick of a free motor.
    pub(super) fn coast(&mut self, limits: &Limits) {
        self.change_speed(0.0, limits.coast_deceleration, limits);
        self.acceleration = 0.0;
    }

    fn change_speed(&mut self, wanted: f64, acceleration: f64, limits: &Limits) {
        let most = acceleration * TICK_S;
        let change = (wanted - self.velocity).clamp(-most, most);
        self.velocity += change;
        self.acceleration = change / TICK_S;
        self.position += self.velocity * TICK_S;
        let way = limits.stops.map(|stops| stops.hold(self.position));
        self.is_pressed = way.is_some_and(|way| way != self.position);
        if let (true, Some(way)) = (self.is_pressed, way) {
            (self.position, self.velocity, self.acceleration) = (way, 0.0, 0.0);
        }
    }

    /// Stops exactly at a reference that stands still, once it is that near; returns whether it rests there.
    pub(super) fn settle(&mut self, reference: f64, limits: &Limits) -> bool {
        let near = |position: f64| (position - reference).abs() < ARRIVED_COUNTS;
        let [first, second] = self.smoothed;
        let slow = match limits.gains {
            None => self.velocity.abs() <= limits.motor_acceleration * TICK_S,
            Some(_) => self.velocity.abs() * TICK_S < ARRIVED_COUNTS / 100.0,
        };
        let [first, second] = match limits.gains {
            None => [first, second],
            Some(_) => [reference; 2],
        };
        let arrived = slow && near(self.position) && near(first) && near(second);
        if arrived {
            *self = Self {
                position: reference,
                smoothed: [reference; 2],
                feedback: self.feedback,
                ..Self::default()
            };
        }
        arrived
    }
}

/// Speed at which `error` is closed without overshoot: proportional near zero, a braking curve farther out.
fn approach_speed(error: f64, acceleration: f64) -> f64 {
    let braking = acceleration * BRAKING_SHARE;
    let linear_up_to = braking / (POSITION_GAIN * POSITION_GAIN);
    let distance = error.abs();
    if distance <= linear_up_to {
        return error * POSITION_GAIN;
    }
    (2.0 * braking * (distance - linear_up_to / 2.0))
        .sqrt()
        .copysign(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        profile_speed: 800_000.0,
        profile_acceleration: 10e6,
        motor_speed: 800_000.0,
        motor_acceleration: 10e6,
        coast_deceleration: 1e6,
        lost_phase: None,
        stops: None,
        gains: None,
    };

    #[test]
    fn step_is_reached_without_overshoot_within_the_limits() {
        let mut motor = Motor::default();
        let mut ticks = 0;
        while !motor.settle(5_000.0, &LIMITS) {
            motor.follow(5_000.0, &LIMITS);
            ticks += 1;
            assert!(motor.position < 5_001.0, "overshoot to {}", motor.position);
            assert!(motor.acceleration.abs() <= 10e6 * (1.0 + 1e-9));
            assert!(motor.velocity.abs() <= 800_000.0);
            assert!(ticks < 800, "not there after 200 ms: {motor:?}");
        }
        assert_eq!((motor.position, motor.velocity), (5_000.0, 0.0));
    }

    #[test]
    fn stream_of_steps_is_followed_with_a_small_constant_lag() {
        let mut motor = Motor::default();
        let mut reference = 0.0;
        let mut lags = Vec::new();
        for tick in 0..4_000 {
            if tick % 4 == 0 {
                reference += 300.0;
                lags.push(reference - motor.position);
            }
            motor.follow(reference, &LIMITS);
        }
        let late = &lags[500..];
        let (least, most) = late.iter().fold((f64::MAX, f64::MIN), |(a, b), lag| {
            (a.min(*lag), b.max(*lag))
        });
        assert!(most - least < 1.0, "lag wanders from {least} to {most}");
        assert!((400.0..1_200.0).contains(&most), "lag {most}");
    }

    #[test]
    fn free_motor_coasts_to_a_stop() {
        let mut motor = Motor {
            velocity: 100_000.0,
            ..Motor::default()
        };
        (0..400).for_each(|_| motor.coast(&LIMITS));
        assert_eq!(motor.velocity, 0.0);
        // v^2 / 2a = 5000 counts, less half a tick.
        assert!(
            (motor.position - 5_000.0).abs() < 15.0,
            "{}",
            motor.position
        );
    }
}
