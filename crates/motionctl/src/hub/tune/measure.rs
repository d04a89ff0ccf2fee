//! Steps there and back, and the feedback meanwhile.

use can_motion::wheel::{WheelConfig, WheelLimits, WheelMode, WheelSnapshot};
use zlac8030l::objects;

use super::arguments::{Arguments, Of};
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::look::Look;
use crate::hub::station::WheelStation;
use crate::interrupt;
use crate::tune::{Measured, Sample};

const CYCLE_US: u32 = 10_000;
/// 4 ms as the guide counts ticks, 8 ms as CiA 301 does (Z11).
const FEEDBACK_TICKS: u16 = 8;
/// Time before the first step.
const REST_US: u64 = 300_000;
/// The target of a step goes out at once.
const MOST_STEP: u32 = 1_000_000;

/// A step, in the unit of the targets and in that of the samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// 1/n r/min or counts, as the drive takes them.
    base: i32,
    height: i32,
    /// 0.1 r/min or counts of a sample for 1 of a target.
    per_target: f64,
}

impl Step {
    /// The step of the options.
    ///
    /// # Errors
    /// [`HubError::Input`] where a step would be nothing, or the bus's.
    pub(super) fn new(arguments: &Arguments, bus: &mut Bus, look: &Look) -> Result<Self, HubError> {
        let step = match arguments.of {
            Of::Speed => Self {
                base: 0,
                height: look.units(arguments.rpm.into()).round() as i32,
                per_target: 10.0 / look.units(1.0),
            },
            Of::Position => Self {
                base: bus.read(look.node, objects::ACTUAL_POSITION)?,
                height: (arguments.amplitude * look.counts_per_turn).round() as i32,
                per_target: 1.0,
            },
        };
        // 60FFh is limited to +-1000 whatever it counts (Z34).
        let is_speed = arguments.of == Of::Speed;
        if step.height == 0 || (is_speed && step.height > 1_000) {
            return Err(HubError::Input(format!(
                "a step of {} r/min or {} turns is nothing that node {} can be told (202Fh:05 is {}, 200Bh makes {} counts of a turn)",
                arguments.rpm,
                arguments.amplitude,
                look.node,
                look.speed_resolution,
                look.counts_per_turn
            )));
        }
        Ok(step)
    }

    /// Height in the unit of the samples.
    pub(super) fn height(&self) -> i32 {
        self.in_samples(self.height)
    }

    fn in_samples(&self, value: i32) -> i32 {
        (f64::from(value) * self.per_target).round() as i32
    }

    fn wheel(&self, arguments: &Arguments, look: &Look) -> WheelConfig {
        let wheel = look.follows_speeds(f64::from(arguments.rpm), 1.0, CYCLE_US);
        let values = |limits: WheelLimits| {
            let mut limits = limits;
            limits.values.max_step = MOST_STEP;
            limits
        };
        let wheel = match arguments.of {
            Of::Speed => WheelConfig {
                limits: WheelLimits {
                    // The answer is what is looked at: one that swings twice as high ends it.
                    following_speed: arguments.rpm.saturating_mul(30),
                    ..values(wheel.limits)
                },
                ..wheel
            },
            Of::Position => {
                let reach = self.height.unsigned_abs() + look.counts_per_turn as u32 / 2;
                let limits = WheelLimits {
                    following_error: reach,
                    ..WheelLimits::position(
                        self.base.saturating_sub(reach as i32),
                        self.base.saturating_add(reach as i32),
                        MOST_STEP,
                        MOST_STEP,
                    )
                };
                WheelConfig {
                    mode: WheelMode::Position {
                        profile_speed_rpm: arguments.rpm,
                    },
                    limits,
                    ..wheel
                }
            }
        };
        WheelConfig {
            ramp_ms: arguments.ramp_ms,
            ..wheel
        }
    }

    fn sample(&self, of: Of, wheel: &WheelSnapshot, first_us: f64) -> Option<(Sample, u64)> {
        let read = match of {
            Of::Speed => wheel.feedback.speed_decirpm,
            Of::Position => wheel.feedback.position_counts,
        }?;
        let base = self.in_samples(self.base);
        let sample = Sample {
            at_ms: (read.at.as_us() as f64 - first_us) / 1_000.0,
            set_point: self.in_samples(wheel.sent).wrapping_sub(base),
            actual: read.value.wrapping_sub(base),
        };
        Some((sample, read.at.as_us()))
    }
}

/// Enables, steps, switches off.
pub(super) fn measure(
    bus: &mut Bus,
    arguments: &Arguments,
    look: &Look,
    step: Step,
) -> Result<Measured, HubError> {
    let wheel = step.wheel(arguments, look);
    let mut station = WheelStation::with_feedback(bus.link(), &[wheel], CYCLE_US, FEEDBACK_TICKS)?;
    let measured = station
        .bring_up()
        .and_then(|()| steps(&mut station, arguments, step));
    let (measured, _) = station.end(measured)?;
    Ok(measured)
}

fn steps(
    station: &mut WheelStation<'_>,
    arguments: &Arguments,
    step: Step,
) -> Result<Measured, HubError> {
    let hold_us = u64::from(arguments.hold_ms) * 1_000;
    let end_us = 2 * hold_us * u64::from(arguments.periods);
    let start = station.now();
    // The cycle in which the first step went out.
    let mut first_us: Option<u64> = None;
    let mut samples: Vec<(u64, Sample)> = Vec::new();
    let mut seen_us = None;
    while interrupt::requests() == 0 {
        let now_us = station.now().as_us();
        let elapsed_us = first_us.map(|first_us| now_us.saturating_sub(first_us));
        if elapsed_us.is_some_and(|elapsed_us| elapsed_us >= end_us) {
            return Ok(finish(samples, first_us, true));
        }
        let has_rested = now_us.saturating_sub(start.as_us()) >= REST_US;
        let is_up = elapsed_us.map_or(has_rested, |us| (us / hold_us).is_multiple_of(2));
        let target = step.base + if is_up { step.height } else { 0 };
        station.cycle(|master, _| {
            // Refused after a fault, which is looked for below.
            let _ = master.set_target(0, target);
        })?;
        if is_up && first_us.is_none() {
            first_us = Some(station.now().as_us());
        }
        if let Some((node, fault)) = station.first_fault() {
            return Err(HubError::WheelFault { node, fault });
        }
        let Some(wheel) = station.snapshots().next() else {
            break;
        };
        if let Some((sample, at_us)) = step.sample(arguments.of, &wheel, 0.0)
            && seen_us != Some(at_us)
        {
            seen_us = Some(at_us);
            samples.push((at_us, sample));
        }
    }
    Ok(finish(samples, first_us, false))
}

/// Times count from the first step.
fn finish(samples: Vec<(u64, Sample)>, first_us: Option<u64>, is_complete: bool) -> Measured {
    let first_us = first_us.unwrap_or_default() as f64;
    let samples = samples.into_iter().map(|(at_us, sample)| Sample {
        at_ms: (at_us as f64 - first_us) / 1_000.0,
        ..sample
    });
    Measured {
        samples: samples.collect(),
        is_complete,
    }
}
