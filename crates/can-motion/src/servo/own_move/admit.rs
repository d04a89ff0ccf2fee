//! Whether a drive may make a motion by itself: ranges, travel, speed and acceleration of the axis.

use core::num::NonZeroU32;

use bus_user::Instant;
use dyn_can::{Amplitude, Counts28, FrequencyHz, ParamGroup2, SpeedRpm};

use super::curve::{Curve, change_per_cycle, counts_per_s, divided_up, per_cycle, soft_start_us};
use super::{Kind, OwnMove};
use crate::core::drive_move::{DriveMove, MoveRefusal, WaveShape};
use crate::servo::config::MasterConfig;
use crate::servo::drive::Servo;

/// The longest move, by the formulas: the master tells times of up to 17 minutes apart.
const LONGEST_MS: u64 = 500_000;
/// So many times as long as the formulas say a motion may take.
pub(super) const MARGIN: u64 = 2;
/// A position that is this old still shows in time that constant speed comes to the end of the travel: polls come at 20 ms.
const READING_AGE_MS: u64 = 60;
/// Counts of excursion of one unit of amplitude: 4096 are 180 degrees of the motor (1.6A section 6, #11). Where that is the whole swing,
/// the motion is half of this (D43).
const AMPLITUDE_UNITS: u64 = 2_048;
/// How long a wave may take to end, in milliseconds.
const WAVE_STOP_MS: u64 = 2_000;

impl Servo {
    /// Speed and acceleration that the drive uses by itself, as read or as configured.
    pub(super) fn own_curve(&self) -> Option<ParamGroup2> {
        self.procedures.curve()
    }

    pub(in crate::servo) fn admit_own_move(
        &self,
        wanted: DriveMove,
        by_trigger: bool,
        config: &MasterConfig,
        now: Instant,
    ) -> Result<(), MoveRefusal> {
        if !self.procedures.are_built() {
            return Err(MoveRefusal::Unsupported);
        }
        match wanted {
            DriveMove::To(counts) => self.admit_travel(counts.into(), config),
            DriveMove::By(counts) => {
                let most = Counts28::MAX.get();
                if super::counts(counts).is_none() {
                    return Err(out_of("distance", "counts", most, counts.unsigned_abs()));
                }
                let end = i64::from(self.ledger.sent_counts()) + i64::from(counts);
                self.admit_travel(end, config)
            }
            _ if by_trigger => Err(MoveRefusal::Unsupported),
            DriveMove::Speed(rpm) => self.admit_speed(rpm, config, now),
            DriveMove::Wave {
                shape,
                amplitude,
                frequency_hz,
            } => self.admit_wave((shape, amplitude, frequency_hz), config),
        }
    }

    fn admit_travel(&self, end: i64, config: &MasterConfig) -> Result<(), MoveRefusal> {
        self.admit_end(end)?;
        let distance = (end - i64::from(self.ledger.sent_counts())).unsigned_abs() as u32;
        let group = self.own_curve().ok_or(MoveRefusal::CurveUnknown)?;
        let ms = Curve::slowest(group, self.config.gear).move_ms(distance);
        if ms > LONGEST_MS {
            let seconds = u32::try_from(ms.div_ceil(1_000)).unwrap_or(u32::MAX);
            return Err(out_of(
                "time of the move",
                "s",
                (LONGEST_MS / 1_000) as i32,
                seconds,
            ));
        }
        let fastest = Curve::fastest(group, self.config.gear);
        self.admit_rate(fastest.peak(distance), config.cycle_us)?;
        let acceleration = fastest.acceleration.get();
        self.admit_change(change_per_cycle(acceleration, config.cycle_us))
    }

    fn admit_end(&self, end: i64) -> Result<(), MoveRefusal> {
        let travel = self.config.limits.travel;
        let (min, max) = (travel.min_counts, travel.max_counts);
        if end < i64::from(min) || end > i64::from(max) {
            return Err(MoveRefusal::Travel {
                min,
                max,
                actual: end,
            });
        }
        Ok(())
    }

    fn admit_rate(&self, counts_per_s: u64, cycle_us: u32) -> Result<(), MoveRefusal> {
        let most = u32::from(self.config.limits.max_step.get());
        match per_cycle(counts_per_s, cycle_us) {
            actual if actual > most => Err(MoveRefusal::TooFast { most, actual }),
            _ => Ok(()),
        }
    }

    fn admit_change(&self, actual: u32) -> Result<(), MoveRefusal> {
        let most = self.config.limits.max_step_change.per_256_cycles();
        if actual > most {
            return Err(MoveRefusal::TooSudden { most, actual });
        }
        Ok(())
    }

    fn admit_speed(
        &self,
        rpm: i32,
        config: &MasterConfig,
        now: Instant,
    ) -> Result<(), MoveRefusal> {
        let magnitude = rpm.unsigned_abs();
        let most = i32::from(SpeedRpm::MAX.get());
        if magnitude == 0 || magnitude > most.unsigned_abs() {
            return Err(out_of(
                "speed in either direction",
                "r/min",
                most,
                magnitude,
            ));
        }
        if self.config.load_can_fall {
            return Err(MoveRefusal::LoadCanFall);
        }
        let group = self.own_curve().ok_or(MoveRefusal::CurveUnknown)?;
        let speed = counts_per_s(magnitude, self.config.gear);
        self.admit_rate(speed, config.cycle_us)?;
        // An S-curve is at most twice as steep as the line through its ends.
        let acceleration = divided_up(2 * speed * 1_000_000, soft_start_us(group));
        self.admit_change(change_per_cycle(acceleration, config.cycle_us))?;
        let reached = self.speed_reach(rpm, group);
        self.admit_end(i64::from(self.ledger.sent_counts()) + 2 * reached)?;
        self.admit_way_back(now)
            .then_some(())
            .ok_or(MoveRefusal::Wear)
    }

    /// How far constant speed goes on from a position that was just read, when it is stopped then, in counts with their sign.
    pub(super) fn speed_reach(&self, rpm: i32, group: ParamGroup2) -> i64 {
        let speed = counts_per_s(rpm.unsigned_abs(), self.config.gear);
        let ms = soft_start_us(group).get().div_ceil(1_000) + READING_AGE_MS;
        let counts = (speed * ms).div_ceil(1_000) as i64;
        if rpm < 0 { -counts } else { counts }
    }

    fn admit_wave(
        &self,
        (shape, amplitude, frequency_hz): (WaveShape, i32, i32),
        config: &MasterConfig,
    ) -> Result<(), MoveRefusal> {
        let (most, fastest) = (
            i32::from(Amplitude::MAX.get()),
            i32::from(FrequencyHz::MAX.get()),
        );
        if !(1..=most).contains(&amplitude) {
            return Err(range(
                "amplitude",
                "of 4096 for half a turn",
                most,
                amplitude,
            ));
        }
        if !(1..=fastest).contains(&frequency_hz) {
            return Err(range("frequency", "Hz", fastest, frequency_hz));
        }
        let excursion = self.excursion(amplitude.unsigned_abs());
        for end in [-excursion, excursion] {
            self.admit_end(i64::from(self.ledger.sent_counts()) + end)?;
        }
        let excursion = excursion.unsigned_abs();
        let (speed, acceleration) = match shape {
            // From one side to the other in one step.
            WaveShape::Square => {
                let cycle_us = NonZeroU32::new(config.cycle_us).unwrap_or(NonZeroU32::MIN);
                let cycles = divided_up(1_000_000, cycle_us.into());
                let speed = 2 * excursion * cycles;
                (speed, speed * cycles)
            }
            // 2 pi f A and (2 pi f)^2 A.
            WaveShape::Sine => {
                let hz = u64::from(frequency_hz.unsigned_abs());
                let speed = (excursion * hz * 6_284).div_ceil(1_000);
                (speed, (excursion * hz * hz * 39_479).div_ceil(1_000))
            }
        };
        self.admit_rate(speed, config.cycle_us)?;
        self.admit_change(change_per_cycle(acceleration, config.cycle_us))
    }

    /// How far a wave leads away from its base, in counts.
    pub(super) fn excursion(&self, amplitude: u32) -> i64 {
        let gear = u64::from(self.config.gear.get());
        (u64::from(amplitude) * gear).div_ceil(AMPLITUDE_UNITS) as i64
    }

    /// The motion that was admitted.
    pub(in crate::servo) fn own_move(
        &self,
        wanted: DriveMove,
        config: &MasterConfig,
    ) -> Option<OwnMove> {
        let start_counts = self.ledger.sent_counts();
        let group = self.own_curve();
        let (kind, end_counts, ms) = match wanted {
            DriveMove::To(end) => (Kind::To, end, self.move_ms(start_counts, end)?),
            DriveMove::By(counts) => {
                let end = start_counts.wrapping_add(counts);
                (Kind::By, end, self.move_ms(start_counts, end)?)
            }
            DriveMove::Speed(rpm) => {
                let ms = soft_start_us(group?).get().div_ceil(1_000);
                (Kind::Speed(SpeedRpm::new(rpm).ok()?), start_counts, ms)
            }
            DriveMove::Wave {
                shape,
                amplitude,
                frequency_hz,
            } => {
                let amplitude = Amplitude::new(amplitude).ok()?;
                let frequency = FrequencyHz::new(frequency_hz).ok()?;
                let kind = match shape {
                    WaveShape::Square => Kind::Square(amplitude, frequency),
                    WaveShape::Sine => Kind::Sine(amplitude, frequency),
                };
                (kind, start_counts, WAVE_STOP_MS)
            }
        };
        let timeouts = &config.timeouts;
        let settle_us = [
            timeouts.confirm_us,
            timeouts.arrival_us,
            timeouts.standstill_us,
        ];
        let settle_ms: u64 = settle_us.map(|us| u64::from(us) / 1_000 + 1).iter().sum();
        let limit_ms = MARGIN * ms + settle_ms;
        Some(OwnMove {
            start_counts,
            end_counts,
            limit_ms: u32::try_from(limit_ms).unwrap_or(u32::MAX),
            told_ms: 0,
            kind,
            told: 0,
            is_stopping: false,
            is_idle: false,
            is_seen: false,
        })
    }

    fn move_ms(&self, start: i32, end: i32) -> Option<u64> {
        let slowest = Curve::slowest(self.own_curve()?, self.config.gear);
        Some(slowest.move_ms(end.abs_diff(start)))
    }

    /// Where a move with an end can stop, in counts, from a position that is so many milliseconds old.
    pub(super) fn stop_counts(&self, own: &OwnMove, position: i32, age_ms: u64) -> i32 {
        let Some(group) = self.own_curve() else {
            return own.end_counts;
        };
        let fastest = Curve::fastest(group, self.config.gear);
        let gone = position.abs_diff(own.start_counts);
        let lead = fastest.speed.get().saturating_mul(age_ms).div_ceil(1_000);
        let here = u64::from(gone).saturating_add(lead);
        // On the way up, the drive stops in what it took to get there; it never gets beyond its end.
        let braking = fastest.braking_counts().min(here);
        let stop = here.saturating_add(braking);
        let whole = own.end_counts.abs_diff(own.start_counts);
        let stop = u32::try_from(stop).unwrap_or(u32::MAX).min(whole);
        if own.end_counts < own.start_counts {
            own.start_counts.wrapping_sub_unsigned(stop)
        } else {
            own.start_counts.wrapping_add_unsigned(stop)
        }
    }
}

/// A magnitude that is 0 or more than `max`.
fn out_of(quantity: &'static str, unit: &'static str, max: i32, actual: u32) -> MoveRefusal {
    range(
        quantity,
        unit,
        max,
        i32::try_from(actual).unwrap_or(i32::MAX),
    )
}

const fn range(quantity: &'static str, unit: &'static str, max: i32, actual: i32) -> MoveRefusal {
    MoveRefusal::Range {
        quantity,
        unit,
        min: 1,
        max,
        actual,
    }
}
