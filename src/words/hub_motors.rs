//! Of ZLAC8030L hub-motor drives.

use can_motion::wheel::{WheelEventKind, WheelFault, Zlac};

use super::{Who, Words};

impl Words for Zlac {
    fn write(axis: Option<u8>, kind: &WheelEventKind) {
        let who = Who(axis);
        match *kind {
            WheelEventKind::State { from, to, reason } => {
                defmt::info!("{}: {} -> {} ({})", who, from, to, reason);
            }
            WheelEventKind::Fault(fault) => write_fault(who, fault),
            WheelEventKind::FoundOn => defmt::warn!(
                "{}: it is enabled, and this board did not enable it: it is left alone until enable becomes active, or the stop circuit opens",
                who
            ),
            WheelEventKind::DisableUnconfirmed { repeated } => defmt::error!(
                "{}: it did not confirm that it is disabled, told again {=u32} x: the drive may still have power; the command is repeated until the drive confirms it",
                who,
                repeated
            ),
            WheelEventKind::SetUp(report) => defmt::info!("{}: set up, {}", who, report),
            WheelEventKind::Nmt(state) => defmt::info!("{}: {}", who, state),
            WheelEventKind::BusError(kind) => defmt::warn!("{}: error: {}", who, kind),
            WheelEventKind::BusOff => {
                defmt::error!("{}: off: check wiring, termination and bit rate", who);
            }
            WheelEventKind::BusRecovered => defmt::info!("{}: works again", who),
            other => defmt::warn!("{}: {}", who, other),
        }
    }
}

/// What is wrong, and the next step.
fn write_fault(who: Who, fault: WheelFault) {
    match fault {
        WheelFault::SwitchedOn => {
            defmt::error!(
                "{}: enabled by somebody else: look for a second master",
                who
            );
        }
        WheelFault::EmergencyInput => defmt::error!(
            "{}: an emergency stop input of the drive is active: release it, then make enable active again",
            who
        ),
        WheelFault::Lost => defmt::error!(
            "{}: no answer: check power, wiring, termination, node and bit rate",
            who
        ),
        WheelFault::Reboot => defmt::error!("{}: it started again: look at its supply", who),
        WheelFault::FollowingSpeed {
            sent_decirpm,
            actual_decirpm,
        } => defmt::error!(
            "{}: turns at {=i32} in place of {=i32} tenths of r/min: blocked, too slow, or driven by something else",
            who,
            actual_decirpm,
            sent_decirpm
        ),
        WheelFault::FollowingError { counts } => defmt::error!(
            "{}: off by {=i32} counts: blocked, slipping, or too slow",
            who,
            counts
        ),
        WheelFault::SpeedResolution { expected, actual } => defmt::error!(
            "{}: its speeds count 1/{=u32} r/min (202Fh:05), the configuration says 1/{=u16}: correct one of the two; it is not enabled",
            who,
            actual,
            expected
        ),
        WheelFault::Bus => defmt::error!("{}: no command got out: check the bus", who),
        WheelFault::ConfirmTimeout => {
            defmt::error!("{}: it did not confirm in time, or its wheel turns", who);
        }
        WheelFault::Group => defmt::error!("{}: stopped with the others", who),
        other => defmt::error!("{}: {}", who, other),
    }
}
