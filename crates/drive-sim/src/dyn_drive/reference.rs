//! Where the commanded position comes from.
//!
//! Specification: Go_Relative_Pos_PD moves the reference at once; a built-in move runs it along a trapezoid of the parameters and is busy until it is
//! there; a new target replaces the running one at once (DYN2 manual A1.8 section 7, dynamic target update); a free motor has no error.
//!
//! Not stated and chosen so that no count is ever lost: a PD step during a built-in move or wave shifts that move or wave, and a relative
//! move starts from the target of the move that it replaces.

use core::f64::consts::TAU;

use super::servo::{Limits, TICK_S};

/// The two built-in waves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WaveKind {
    Square,
    Sine,
}

/// A wave around a position. The amplitude is half of the peak-to-peak value (D43).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wave {
    pub(super) kind: WaveKind,
    pub(super) amplitude_counts: f64,
    pub(super) frequency_hz: f64,
}

impl Wave {
    fn offset(&self, time_s: f64) -> f64 {
        let turns = self.frequency_hz * time_s;
        match self.kind {
            WaveKind::Square if turns.fract() < 0.5 => self.amplitude_counts,
            WaveKind::Square => -self.amplitude_counts,
            WaveKind::Sine => self.amplitude_counts * (TAU * turns.fract()).sin(),
        }
    }
}

/// What moves the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Generator {
    /// Nothing, and the motor is free.
    Free,
    /// Nothing but PD steps.
    Hold,
    /// A built-in move with its present speed.
    Profile { target: f64, velocity: f64 },
    /// A built-in wave.
    Wave { wave: Wave, base: f64, ticks: u64 },
    /// The motor turns at a speed and there is no commanded position.
    Speed {
        velocity: f64,
        /// Acceleration of the soft start.
        ramp: f64,
    },
}

impl Generator {
    /// One tick of a generator that has a reference; the reference of the others is the shaft.
    pub(super) fn advance(&mut self, reference: &mut f64, limits: &Limits) {
        match self {
            Self::Free | Self::Hold | Self::Speed { .. } => {}
            Self::Profile { target, velocity } => {
                if advance_profile(reference, velocity, *target, limits) {
                    *self = Self::Hold;
                }
            }
            Self::Wave { wave, base, ticks } => {
                *ticks += 1;
                *reference = *base + wave.offset(*ticks as f64 * TICK_S);
            }
        }
    }
}

/// One tick of a trapezoid; returns whether it has arrived.
fn advance_profile(position: &mut f64, velocity: &mut f64, target: f64, limits: &Limits) -> bool {
    let most = limits.profile_acceleration * TICK_S;
    let left = target - *position;
    if left.abs() <= most * TICK_S && velocity.abs() <= 2.0 * most {
        *position = target;
        return true;
    }
    // The fastest speed from which whole ticks of full deceleration end at the target.
    let braking = (2.0 * limits.profile_acceleration * left.abs() + most * most / 4.0).sqrt();
    let wanted = (braking - most / 2.0)
        .min(limits.profile_speed)
        .copysign(left);
    *velocity += (wanted - *velocity).clamp(-most, most);
    *position += *velocity * TICK_S;
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// MaxSpd 48 and MaxAcl 30 at gear number 4096, in counts of 16384 a turn.
    fn worked_example() -> Limits {
        let speed = 1_984.888 / 60.0 * 16_384.0;
        let acceleration = 19_073.4 / 60.0 * 16_384.0;
        Limits {
            profile_speed: speed,
            profile_acceleration: acceleration,
            motor_speed: speed,
            motor_acceleration: acceleration,
            coast_deceleration: 1e6,
            lost_phase: None,
            stops: None,
            gains: None,
        }
    }

    fn run(target: f64) -> (f64, f64) {
        let limits = worked_example();
        let mut reference = 0.0;
        let mut generator = Generator::Profile {
            target,
            velocity: 0.0,
        };
        let (mut ticks, mut farthest) = (0_u32, 0.0_f64);
        while generator != Generator::Hold {
            generator.advance(&mut reference, &limits);
            ticks += 1;
            farthest = farthest.max(reference.abs());
            assert!(ticks < 100_000);
        }
        assert_eq!(reference, target);
        (f64::from(ticks) * TICK_S, farthest)
    }

    #[test]
    fn worked_example_of_the_manual_takes_its_time() {
        // DYN2 manual A1.8 section 7: 140000 counts take 0.362 s.
        let (time_s, farthest) = run(140_000.0);
        assert!((time_s - 0.362).abs() < 0.003, "{time_s}");
        assert_eq!(farthest, 140_000.0);
    }

    #[test]
    fn short_and_backward_moves_arrive_exactly() {
        for target in [1.0, -1.0, 7.0, -350.0, 12_345.0] {
            let (_, farthest) = run(target);
            assert!(farthest <= f64::abs(target) + 1.0, "{target}: {farthest}");
        }
    }

    #[test]
    fn waves_start_at_their_base_and_swing_both_ways() {
        let wave = |kind| Wave {
            kind,
            amplitude_counts: 100.0,
            frequency_hz: 1.0,
        };
        let square = [0.1, 0.4, 0.6, 1.1].map(|time_s| wave(WaveKind::Square).offset(time_s));
        assert_eq!(square, [100.0, 100.0, -100.0, 100.0]);
        let sine = [0.0, 0.25, 0.75].map(|time_s| wave(WaveKind::Sine).offset(time_s).round());
        assert_eq!(sine, [0.0, 100.0, -100.0]);
    }
}
