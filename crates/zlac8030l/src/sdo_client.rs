//! SDO client of one drive, sans-I/O: frames in and out, time as an argument, in microseconds.
//!
//! It believes nothing. A reply counts only when it comes from this drive, with 8 bytes, while a transfer runs, about the object and in
//! the direction of that transfer. After a timeout the client stays quiet for one more timeout, because SDO replies carry no number: a
//! late reply of the same object would otherwise confirm the next write, which may never have arrived.
//!
//! ```text
//!          start              reply, abort
//!  Idle ----------> Pending ---------------> Settling (same object only) --> Idle
//!                     |
//!                     | timeout, wrong specifier: abort frame
//!                     +--------------------> Quarantined ------------------> Idle
//! ```

use core::fmt;

use crate::abort::AbortCode;
use crate::error::DecodeError;
use crate::frame::DataFrame;
use crate::node::{NodeId, Service};
use crate::object::{ObjectAddress, ObjectData};
use crate::objects;
use crate::sdo::{SdoReply, SdoRequest, address_of};

/// Waiting times and tolerances of a client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SdoTimeouts {
    /// From a request to the end of waiting for its reply, and once more until the next request. No document has a figure.
    pub reply_us: u32,
    /// After a reply, before the same object is asked again: CAN can repeat a frame, and the repeated reply must not answer the next
    /// request.
    pub settle_us: u32,
}

impl SdoTimeouts {
    /// 50 ms for a reply, 1 ms to settle.
    pub const DEFAULT: Self = Self {
        reply_us: 50_000,
        settle_us: 1_000,
    };
}

impl Default for SdoTimeouts {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Wrong replies that the guide prints, each accepted only when it is named here. Default: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SdoQuirks {
    /// A write of 6081h:00 may be confirmed with sub-index 01 (Z1).
    pub profile_speed_confirmed_as_sub_1: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Transfer {
    Idle,
    Pending {
        request: SdoRequest,
        until_us: u64,
    },
    Settling {
        address: ObjectAddress,
        until_us: u64,
    },
    Quarantined {
        until_us: u64,
    },
}

/// Why no transfer can start now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SdoBusy {
    /// Another transfer runs.
    Running {
        /// Its object.
        address: ObjectAddress,
    },
    /// A transfer failed, and its late reply may still come.
    Quarantined {
        /// When the client is free again.
        until_us: u64,
    },
    /// The same object has just been answered.
    Settling {
        /// When it can be asked again.
        until_us: u64,
    },
    /// An abort is no transfer; the client sends its own.
    NoTransfer,
}

impl fmt::Display for SdoBusy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Running { address } => write!(f, "the transfer of {address} has not ended"),
            Self::Quarantined { until_us } => {
                write!(f, "a late reply may come until {until_us} us")
            }
            Self::Settling { until_us } => {
                write!(f, "the same object can be asked again at {until_us} us")
            }
            Self::NoTransfer => f.write_str("an abort starts no transfer"),
        }
    }
}

impl core::error::Error for SdoBusy {}

/// How a transfer ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SdoEnd {
    /// Read.
    Value(ObjectData),
    /// Written.
    Written,
    /// The drive refused.
    Aborted(AbortCode),
    /// The drive did not answer in time.
    TimedOut,
    /// The drive answered about this object with a specifier that is not expedited.
    Specifier {
        /// The specifier.
        actual: u8,
    },
}

/// A transfer has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub struct SdoEvent {
    /// What was asked.
    pub request: SdoRequest,
    /// How it ended.
    pub end: SdoEnd,
    /// A frame that must go out now: the abort that CiA 301 asks of a client that gives up.
    pub abort: Option<DataFrame>,
}

/// Why a frame was not believed. The running transfer, if any, goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SdoIgnored {
    /// Not an SDO reply of this drive.
    Foreign,
    /// No transfer runs: a late or repeated reply, or another client on the bus.
    Unawaited {
        /// The object it names.
        address: ObjectAddress,
    },
    /// About another object.
    Address {
        /// The object of the transfer.
        expected: ObjectAddress,
        /// The object of the reply.
        actual: ObjectAddress,
    },
    /// The confirmation of a write while a read runs, or a value while a write runs.
    Direction,
    /// It does not decode.
    Malformed(DecodeError),
}

/// What a frame meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SdoHeard {
    /// It ended the transfer.
    Ended(SdoEvent),
    /// It was ignored.
    Ignored(SdoIgnored),
}

/// SDO client of one drive. One transfer at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SdoClient {
    node: NodeId,
    timeouts: SdoTimeouts,
    quirks: SdoQuirks,
    transfer: Transfer,
}

impl SdoClient {
    /// A client for a drive that follows CiA 301.
    #[must_use]
    pub const fn new(node: NodeId, timeouts: SdoTimeouts) -> Self {
        Self {
            node,
            timeouts,
            quirks: SdoQuirks {
                profile_speed_confirmed_as_sub_1: false,
            },
            transfer: Transfer::Idle,
        }
    }

    /// The same client with tolerances.
    #[must_use]
    pub const fn with_quirks(mut self, quirks: SdoQuirks) -> Self {
        self.quirks = quirks;
        self
    }

    /// The drive.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// Whether a transfer of this object could start now.
    ///
    /// # Errors
    /// [`SdoBusy`] with the reason.
    pub fn ready(&self, now_us: u64, address: ObjectAddress) -> Result<(), SdoBusy> {
        match self.transfer {
            Transfer::Pending { request, .. } => Err(SdoBusy::Running {
                address: request.address(),
            }),
            Transfer::Quarantined { until_us } if now_us < until_us => {
                Err(SdoBusy::Quarantined { until_us })
            }
            Transfer::Settling {
                address: answered,
                until_us,
            } if answered == address && now_us < until_us => Err(SdoBusy::Settling { until_us }),
            _ => Ok(()),
        }
    }

    /// Starts a transfer, and its timeout with it: call it when the controller accepts the frame.
    ///
    /// # Errors
    /// [`SdoBusy`] with the reason; the running transfer is not disturbed.
    pub fn start(&mut self, now_us: u64, request: SdoRequest) -> Result<DataFrame, SdoBusy> {
        if matches!(request, SdoRequest::Abort(..)) {
            return Err(SdoBusy::NoTransfer);
        }
        self.ready(now_us, request.address())?;
        self.transfer = Transfer::Pending {
            request,
            until_us: now_us + u64::from(self.timeouts.reply_us),
        };
        Ok(request.encode(self.node))
    }

    /// A frame came in, of whatever service.
    pub fn on_frame(&mut self, now_us: u64, frame: &DataFrame) -> SdoHeard {
        if frame.service() != Ok(Service::SdoReply(self.node)) {
            return SdoHeard::Ignored(SdoIgnored::Foreign);
        }
        let actual = address_of(frame);
        let Transfer::Pending { request, .. } = self.transfer else {
            return SdoHeard::Ignored(SdoIgnored::Unawaited { address: actual });
        };
        let expected = request.address();
        let reply = match SdoReply::decode(frame) {
            Ok((_, reply)) => reply,
            // Segmented or block transfer of the right object: the drive waits for what will never come.
            Err(DecodeError::Specifier { actual: specifier }) if actual == expected => {
                return SdoHeard::Ended(self.give_up(
                    now_us,
                    request,
                    SdoEnd::Specifier { actual: specifier },
                    AbortCode::COMMAND_SPECIFIER,
                ));
            }
            Err(error) => return SdoHeard::Ignored(SdoIgnored::Malformed(error)),
        };
        if actual != expected && !self.tolerates(request, reply) {
            return SdoHeard::Ignored(SdoIgnored::Address { expected, actual });
        }
        let end = match (request, reply) {
            (_, SdoReply::Abort(_, code)) => SdoEnd::Aborted(code),
            (SdoRequest::Read(_), SdoReply::Value(_, data)) => SdoEnd::Value(data),
            (SdoRequest::Write(..), SdoReply::Written(_)) => SdoEnd::Written,
            _ => return SdoHeard::Ignored(SdoIgnored::Direction),
        };
        self.transfer = Transfer::Settling {
            address: expected,
            until_us: now_us + u64::from(self.timeouts.settle_us),
        };
        SdoHeard::Ended(SdoEvent {
            request,
            end,
            abort: None,
        })
    }

    /// Lets time pass: ends a transfer whose reply did not come.
    pub fn poll(&mut self, now_us: u64) -> Option<SdoEvent> {
        match self.transfer {
            Transfer::Pending { request, until_us } if now_us >= until_us => {
                Some(self.give_up(now_us, request, SdoEnd::TimedOut, AbortCode::TIMEOUT))
            }
            Transfer::Quarantined { until_us } | Transfer::Settling { until_us, .. }
                if now_us >= until_us =>
            {
                self.transfer = Transfer::Idle;
                None
            }
            _ => None,
        }
    }

    /// When [`Self::poll`] should come next; `None` while idle.
    #[must_use]
    pub const fn poll_at_us(&self) -> Option<u64> {
        match self.transfer {
            Transfer::Idle => None,
            Transfer::Pending { until_us, .. }
            | Transfer::Settling { until_us, .. }
            | Transfer::Quarantined { until_us } => Some(until_us),
        }
    }

    /// The bus failed, or the drive restarted: a running transfer ends without a word, and its reply may still come.
    pub fn abandon(&mut self, now_us: u64) {
        if matches!(self.transfer, Transfer::Pending { .. }) {
            self.quarantine(now_us);
        }
    }

    fn give_up(
        &mut self,
        now_us: u64,
        request: SdoRequest,
        end: SdoEnd,
        code: AbortCode,
    ) -> SdoEvent {
        self.quarantine(now_us);
        let abort = SdoRequest::Abort(request.address(), code).encode(self.node);
        SdoEvent {
            request,
            end,
            abort: Some(abort),
        }
    }

    fn quarantine(&mut self, now_us: u64) {
        self.transfer = Transfer::Quarantined {
            until_us: now_us + u64::from(self.timeouts.reply_us),
        };
    }

    fn tolerates(&self, request: SdoRequest, reply: SdoReply) -> bool {
        let profile_speed = objects::PROFILE_SPEED.address();
        let as_printed = SdoReply::Written(ObjectAddress::new(profile_speed.index, 1));
        self.quirks.profile_speed_confirmed_as_sub_1
            && matches!(request, SdoRequest::Write(address, _) if address == profile_speed)
            && reply == as_printed
    }
}

#[cfg(test)]
mod tests;
