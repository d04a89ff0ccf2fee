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

use can_frame::DataFrame;

use crate::abort::AbortCode;
use crate::error::DecodeError;
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
enum Phase {
    Idle,
    Pending,
    Settling,
    Quarantined,
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
    /// The same object has just been answered, or two others.
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
                write!(
                    f,
                    "what was just answered can be asked again at {until_us} us"
                )
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

impl fmt::Display for SdoEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(data) => write!(f, "the drive answered 0x{:X}", data.raw()),
            Self::Written => f.write_str("the drive took the value"),
            Self::Aborted(code) => write!(f, "the drive refused: {code}"),
            Self::TimedOut => f.write_str("the drive did not answer in time"),
            Self::Specifier { actual } => write!(
                f,
                "the drive answered with the specifier 0x{actual:02X}, which is not that of an expedited transfer"
            ),
        }
    }
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
}

impl SdoEvent {
    /// What must go out now: the abort that CiA 301 asks of a client that gives up.
    #[must_use]
    pub const fn abort(&self) -> Option<SdoRequest> {
        let code = match self.end {
            SdoEnd::TimedOut => AbortCode::TIMEOUT,
            SdoEnd::Specifier { .. } => AbortCode::COMMAND_SPECIFIER,
            SdoEnd::Value(_) | SdoEnd::Written | SdoEnd::Aborted(_) => return None,
        };
        Some(SdoRequest::Abort(self.request.address(), code))
    }
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
    phase: Phase,
    /// The latest one.
    request: SdoRequest,
    /// The object that was answered before the latest request began, and settles with it.
    settling: Option<ObjectAddress>,
    /// When the phase ends, unless it is idle.
    until_us: u64,
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
            phase: Phase::Idle,
            request: objects::STATUS_WORD.read(),
            settling: None,
            until_us: 0,
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

    /// Whether a transfer of this object could start now. While two objects settle none does: that is shorter than a transfer takes.
    ///
    /// # Errors
    /// [`SdoBusy`] with the reason.
    pub fn ready(&self, now_us: u64, address: ObjectAddress) -> Result<(), SdoBusy> {
        let (until_us, is_over) = (self.until_us, now_us >= self.until_us);
        match self.phase {
            Phase::Pending => Err(SdoBusy::Running {
                address: self.request.address(),
            }),
            Phase::Quarantined if !is_over => Err(SdoBusy::Quarantined { until_us }),
            Phase::Settling
                if !is_over && (self.request.address() == address || self.settling.is_some()) =>
            {
                Err(SdoBusy::Settling { until_us })
            }
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
        // Its repeated reply may still come, and is not to answer the transfer after this one.
        let is_settling = self.phase == Phase::Settling && now_us < self.until_us;
        self.settling = is_settling.then(|| self.request.address());
        self.request = request;
        self.enter(Phase::Pending, now_us, self.timeouts.reply_us);
        Ok(request.encode(self.node))
    }

    /// A frame came in, of whatever service.
    pub fn on_frame(&mut self, now_us: u64, frame: &DataFrame) -> SdoHeard {
        if frame.id() != Service::SdoReply(self.node).can_id() {
            return SdoHeard::Ignored(SdoIgnored::Foreign);
        }
        let actual = address_of(frame);
        if self.phase != Phase::Pending {
            return SdoHeard::Ignored(SdoIgnored::Unawaited { address: actual });
        }
        let request = self.request;
        let expected = request.address();
        let reply = match SdoReply::content(frame) {
            Ok(reply) => reply,
            // Segmented or block transfer of the right object: the drive waits for what will never come.
            Err(DecodeError::Specifier { actual: specifier }) if actual == expected => {
                self.quarantine(now_us);
                let end = SdoEnd::Specifier { actual: specifier };
                return SdoHeard::Ended(SdoEvent { request, end });
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
        self.enter(Phase::Settling, now_us, self.timeouts.settle_us);
        SdoHeard::Ended(SdoEvent { request, end })
    }

    /// Lets time pass: ends a transfer whose reply did not come.
    pub fn poll(&mut self, now_us: u64) -> Option<SdoEvent> {
        if self.phase == Phase::Idle || now_us < self.until_us {
            return None;
        }
        if self.phase != Phase::Pending {
            self.phase = Phase::Idle;
            return None;
        }
        self.quarantine(now_us);
        Some(SdoEvent {
            request: self.request,
            end: SdoEnd::TimedOut,
        })
    }

    /// When [`Self::poll`] should come next; `None` while idle.
    #[must_use]
    pub const fn poll_at_us(&self) -> Option<u64> {
        match self.phase {
            Phase::Idle => None,
            Phase::Pending | Phase::Settling | Phase::Quarantined => Some(self.until_us),
        }
    }

    /// The bus failed, or the drive restarted: a running transfer ends without a word, and its reply may still come.
    pub fn abandon(&mut self, now_us: u64) {
        if self.phase == Phase::Pending {
            self.quarantine(now_us);
        }
    }

    /// The controller gave the request back unsent: no reply will come.
    pub fn withdraw(&mut self) {
        if self.phase != Phase::Pending {
            return;
        }
        self.phase = Phase::Idle;
        if let Some(address) = self.settling.take() {
            self.request = SdoRequest::Read(address);
            let began_us = self
                .until_us
                .saturating_sub(u64::from(self.timeouts.reply_us));
            self.enter(Phase::Settling, began_us, self.timeouts.settle_us);
        }
    }

    fn quarantine(&mut self, now_us: u64) {
        self.enter(Phase::Quarantined, now_us, self.timeouts.reply_us);
    }

    fn enter(&mut self, phase: Phase, now_us: u64, lasts_us: u32) {
        self.phase = phase;
        self.until_us = now_us.saturating_add(u64::from(lasts_us));
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
