//! What the master and the bus plan refuse, with a number.

use can_motion::plan::Refusal as PlanRefusal;
use can_motion::plan::analysis::Response;
use can_motion::{AxisConfig, ConfigError};
use dyn_can::DriveId;

use crate::refusal::{Kind, Refusal};
use crate::settings::MOST_AXES;

/// Most cycles between two polls: of can-motion.
const MOST_POLL_CYCLES: u32 = 65_535;

impl Refusal {
    /// The refusal of a master with this cycle and these axes.
    pub(crate) fn of_master(error: &ConfigError, cycle_us: u32, axes: &[AxisConfig]) -> Self {
        let place = |drive: DriveId| axes.iter().position(|axis| axis.drive == drive);
        let at = |kind: Kind, drive, expected: i64, actual: i64| Self {
            axis: place(drive).map(|axis| axis as u8),
            ..kind.because(expected, actual)
        };
        match *error {
            ConfigError::AxisCount { actual, .. } => axis_count(actual),
            ConfigError::Order { drive } => {
                let id = i64::from(drive.get());
                at(Kind::Order, drive, id + 1, id)
            }
            ConfigError::Cycle { actual_us } => {
                let nearest = actual_us.clamp(250, 1_000_000);
                Kind::Cycle.because(nearest.into(), actual_us.into())
            }
            ConfigError::BitRate { actual } => {
                Kind::BitRate.because(1_000, actual.kbit_per_s().into())
            }
            ConfigError::NoRequests => Kind::Requests.because(1, 0),
            ConfigError::Travel { drive, min, max } => {
                let (expected, actual) = travel(min, max);
                at(Kind::Travel, drive, expected, actual)
            }
            ConfigError::Tolerance {
                drive,
                following_error,
                actual,
            } => at(
                Kind::Tolerance,
                drive,
                following_error.into(),
                actual.into(),
            ),
            ConfigError::Unwatched { drive } => at(Kind::Unwatched, drive, cycle_us.into(), 0),
            ConfigError::ReadBack { drive } => at(Kind::ReadBack, drive, 1, 0),
            ConfigError::ReadBackRange {
                drive,
                most,
                actual,
            } => at(Kind::ReadBackRange, drive, most.into(), actual.into()),
            ConfigError::PollPeriod {
                drive, actual_us, ..
            } => {
                let most = cycle_us.saturating_mul(MOST_POLL_CYCLES);
                let nearest = if actual_us < cycle_us { cycle_us } else { most };
                at(Kind::PollPeriod, drive, nearest.into(), actual_us.into())
            }
            ConfigError::Plan { refusal, .. } => of_plan(&refusal, axes),
            _ => Kind::Master.because(0, 0),
        }
    }
}

pub(crate) fn axis_count(actual: usize) -> Refusal {
    let nearest = if actual == 0 { 1 } else { MOST_AXES };
    Kind::AxisCount.because(nearest as i64, actual as i64)
}

/// The nearest end that is allowed, and the end given.
fn travel(min: i32, max: i32) -> (i64, i64) {
    let (lowest, highest) = (
        can_motion::Travel::WHOLE.min_counts,
        can_motion::Travel::WHOLE.max_counts,
    );
    if min < lowest {
        (lowest.into(), min.into())
    } else if max > highest {
        (highest.into(), max.into())
    } else {
        (min.into(), max.into())
    }
}

fn of_plan(refusal: &PlanRefusal, axes: &[AxisConfig]) -> Refusal {
    let at = |kind: Kind, number: u8, expected: i64, actual: i64| Refusal {
        axis: axes
            .iter()
            .position(|axis| axis.drive.get() == number)
            .map(|axis| axis as u8),
        ..kind.because(expected, actual)
    };
    match *refusal {
        PlanRefusal::Order { drive } => at(Kind::Order, drive, i64::from(drive) + 1, drive.into()),
        PlanRefusal::ResponseWindow { window } => {
            Kind::ResponseWindow.because(window.min_us.into(), window.max_us.into())
        }
        PlanRefusal::Overload {
            drive,
            load_bits,
            cycle_bits,
        } => at(
            Kind::Overload,
            drive,
            saturated(cycle_bits),
            saturated(load_bits),
        ),
        PlanRefusal::LateSetPoint { drive, response } => Refusal {
            axis: at(Kind::LateSetPoint, drive, 0, 0).axis,
            ..late(Kind::LateSetPoint, response)
        },
        PlanRefusal::LateRequest { response } => late(Kind::LateRequest, response),
        PlanRefusal::LateReply { response } => late(Kind::LateReply, response),
        PlanRefusal::LateAlarm { response } => late(Kind::LateAlarm, response),
        // There are no CANopen devices in the settings.
        PlanRefusal::CanopenNode { .. } | PlanRefusal::Clash(_) => Kind::Master.because(0, 0),
        _ => Kind::Master.because(0, 0),
    }
}

/// A response without bound counts as the largest number.
fn late(kind: Kind, response: Response) -> Refusal {
    let bits = response.bits.map_or(i64::MAX, i64::from);
    kind.because(response.deadline_bits.into(), bits)
}

fn saturated(bits: u64) -> i64 {
    i64::try_from(bits).unwrap_or(i64::MAX)
}
