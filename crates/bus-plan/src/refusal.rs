//! Why a plan is refused, and what to know about one that is not.

use core::fmt;

use crate::analysis::Response;
use crate::canopen::Clash;
use crate::drive::Drive;
use crate::setup::{CycleSetup, ResponseWindow};
use crate::text::Text;

/// Why the bus cannot carry what is planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// The drives are not in ascending order of their numbers, or a drive is given twice.
    Order {
        /// The drive that is not above the one before it.
        drive: u8,
    },
    /// The response window ends before it begins.
    ResponseWindow {
        /// The window.
        window: ResponseWindow,
    },
    /// A CANopen node id outside 1 ..= 127.
    CanopenNode {
        /// The node id given.
        actual: u8,
    },
    /// An identifier means something in both protocols on this bus.
    Clash(Clash),
    /// The frames of a cycle are longer than the cycle.
    Overload {
        /// The first drive whose set-point does not fit any more.
        drive: u8,
        /// Bit times of requests, replies, alarms and errors of a cycle, and of the set-points up to this one.
        load_bits: u64,
        /// Bit times of a cycle.
        cycle_bits: u64,
    },
    /// A set-point may still be on its way when the next cycle starts.
    LateSetPoint {
        /// The first drive to which that may happen.
        drive: u8,
        /// From the start of the cycle.
        response: Response,
    },
    /// A request may still be on its way at its deadline: the end of the next cycle, or of its own when the controller sorts by
    /// identifier.
    LateRequest {
        /// From the start of the cycle.
        response: Response,
    },
    /// A reply may come after [`CycleSetup::reply_us`].
    LateReply {
        /// From the start of the cycle of the request.
        response: Response,
    },
    /// A burst of alarms may last longer than two cycles.
    LateAlarm {
        /// From the moment when the drive offers the frame.
        response: Response,
    },
}

impl Refusal {
    /// What no rate and no number of drives would help against.
    pub(crate) const fn outright(setup: &CycleSetup, drives: &[Drive]) -> Option<Self> {
        let mut rest = drives;
        while let [lower, behind @ ..] = rest {
            if let [upper, ..] = behind
                && upper.number <= lower.number
            {
                return Some(Self::Order {
                    drive: upper.number,
                });
            }
            rest = behind;
        }
        let window = setup.bus.response;
        if window.min_us > window.max_us {
            return Some(Self::ResponseWindow { window });
        }
        if let Some(canopen) = &setup.bus.canopen
            && let Some(actual) = canopen.invalid_node()
        {
            return Some(Self::CanopenNode { actual });
        }
        match setup.clash {
            Some(clash) => Some(Self::Clash(clash)),
            None => None,
        }
    }

    /// Whether other rates, polls or axes would help.
    #[must_use]
    pub const fn is_about_time(&self) -> bool {
        !matches!(
            self,
            Self::Order { .. }
                | Self::ResponseWindow { .. }
                | Self::CanopenNode { .. }
                | Self::Clash(_)
        )
    }

    pub(crate) const fn text(&self) -> Text {
        match *self {
            Self::Order { drive } => Text::EMPTY
                .str("list the axes in ascending order of drive id, each once: drive ")
                .number(drive as u64)
                .str(" is not above the one before it"),
            Self::ResponseWindow {
                window: ResponseWindow { min_us, max_us },
            } => Text::EMPTY
                .str("the response window must not end before it begins, got ")
                .number(min_us as u64)
                .str("..")
                .number(max_us as u64)
                .str(" us"),
            Self::CanopenNode { actual } => Text::EMPTY
                .str("a CANopen node id must be 1..=127, got ")
                .number(actual as u64),
            Self::Clash(clash) => clash_text(&clash),
            Self::Overload {
                drive,
                load_bits,
                cycle_bits,
            } => Text::EMPTY
                .str("set-point of drive ")
                .number(drive as u64)
                .str(" does not fit: with it a cycle carries ")
                .number(load_bits)
                .str(" bit times, but lasts ")
                .number(cycle_bits),
            Self::LateSetPoint { drive, response } => {
                let frame = Text::EMPTY.str("set-point of drive ");
                late(frame.number(drive as u64), &response)
            }
            Self::LateRequest { response } => {
                late(Text::EMPTY.str("last request of a cycle"), &response)
            }
            Self::LateReply { response } => late(Text::EMPTY.str("reply"), &response),
            Self::LateAlarm { response } => late(Text::EMPTY.str("alarm"), &response),
        }
    }
}

const fn late(frame: Text, response: &Response) -> Text {
    let frame = frame.str(" is late: its response time is ");
    let frame = match response.bits {
        Some(bits) => frame.number(bits as u64).str(" bit times"),
        None => frame.str("without bound"),
    };
    frame
        .str(", its deadline ")
        .number(response.deadline_bits as u64)
}

const fn clash_text(clash: &Clash) -> Text {
    let text = Text::EMPTY
        .str("CANopen ")
        .str(clash.canopen.service.name())
        .str(" ");
    let text = text.hex(clash.canopen.id as u64).str(" is ");
    let text = text.str(clash.meaning).str(" of ");
    let text = match clash.drive {
        Some(drive) => text.str("drive ").number(drive as u64),
        None => text.str("every drive"),
    };
    text.str(": use separate buses")
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text().as_str())
    }
}

impl core::error::Error for Refusal {}

/// What is worth knowing about a plan that is not refused for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Warning {
    /// Identifiers from 0x7F0 on begin with seven recessive bits, which some old controllers cannot send.
    HighIdentifiers {
        /// The drive that has them.
        drive: u8,
    },
    /// More polls are due than requests may go out: every period gets longer.
    PollsStretched {
        /// Real period per configured period in thousandths, above 1000.
        permille: u32,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::HighIdentifiers { drive } => write!(
                f,
                "identifiers of drive {drive} from 0x7F0 on cannot be sent by some old controllers: choose another id"
            ),
            Self::PollsStretched { permille } => write!(
                f,
                "more polls are due than requests_per_cycle allows: their periods grow to {}.{} %",
                permille / 10,
                permille % 10
            ),
        }
    }
}
