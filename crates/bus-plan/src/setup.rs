//! What the plan must know about the bus beyond the settings of the master.

use can_frame::BitRate;
use can_frame::wire::{INTERFRAME_BITS, bound_bits};

use crate::canopen::{Canopen, Clash};
use crate::drive::Requests;

/// Which of the waiting frames of the master takes part in arbitration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TxOrder {
    /// The most urgent (bxCAN with TXFP = 0, FDCAN transmit queue).
    Identifier,
    /// The oldest (bxCAN with TXFP = 1, FDCAN transmit FIFO).
    Fifo,
}

/// Time from the end of a request on the wire until the drive offers its reply to the bus.
///
/// The documents lost their figure (D65): measure it, over all drives of the bus, and leave a margin. The narrower the
/// window, the more the plan admits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResponseWindow {
    /// Shortest time in microseconds.
    pub min_us: u32,
    /// Longest time in microseconds, at least `min_us`.
    pub max_us: u32,
}

/// What is asked while set-points are streamed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RequestMix {
    /// The polls of the axes: all axes are brought up before the first one streams.
    Polls,
    /// Anything up to the longest request and reply of the protocol: axes are brought up, or parameters read and written, while
    /// other axes stream.
    Any,
}

/// What the plan must know about the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BusSetup {
    /// Bit rate.
    pub bit_rate: BitRate,
    /// In which order the controller of the master sends what waits in it.
    pub order: TxOrder,
    /// How long the drives take to answer.
    pub response: ResponseWindow,
    /// What is asked while set-points are streamed.
    pub requests: RequestMix,
    /// Longest delay in microseconds from the nominal start of a cycle until its frames are offered to the controller.
    pub release_jitter_us: u32,
    /// Most alarm frames of all drives together in any two cycles in which set-points must still be on time. 0 is usual: an
    /// alarm stops its group at once, so a set-point that it delays does no harm.
    pub alarm_burst: u8,
    /// Shortest time in microseconds between two errors on the bus that set-points must survive on time; `None`: no errors.
    pub error_interval_us: Option<u32>,
    /// CANopen devices on the same bus.
    pub canopen: Option<Canopen>,
}

impl BusSetup {
    /// 1 Mbit/s, first-in-first-out transmission, answers within 2 ms, polls only, no release jitter, no alarms, no errors,
    /// no CANopen.
    pub const DEFAULT: Self = Self {
        bit_rate: BitRate::Kbit1000,
        order: TxOrder::Fifo,
        response: ResponseWindow {
            min_us: 0,
            max_us: 2_000,
        },
        requests: RequestMix::Polls,
        release_jitter_us: 0,
        alarm_burst: 0,
        error_interval_us: None,
        canopen: None,
    };
}

impl ResponseWindow {
    /// What covers both windows.
    #[must_use]
    pub fn union(left: Option<Self>, right: Option<Self>) -> Option<Self> {
        match (left, right) {
            (Some(left), Some(right)) => Some(Self {
                min_us: left.min_us.min(right.min_us),
                max_us: left.max_us.max(right.max_us),
            }),
            (one, other) => one.or(other),
        }
    }
}

impl BusSetup {
    /// Time on the wire of a frame with so many bytes, half way between its shortest and its longest form.
    #[must_use]
    pub const fn usual_us(&self, len: u8) -> u32 {
        let shortest_bits = 44 + 8 * len as u32;
        let longest_bits = (bound_bits(len) - INTERFRAME_BITS) as u32;
        self.bit_rate
            .us_covering((shortest_bits + longest_bits) / 2)
    }
}

impl Default for BusSetup {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a plan of cycles is made for, apart from its drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleSetup {
    /// The bus.
    pub bus: BusSetup,
    /// Time from one cycle to the next in microseconds.
    pub cycle_us: u32,
    /// Requests that may go out in one cycle.
    pub requests_per_cycle: u8,
    /// How long the master waits for a reply, in microseconds.
    pub reply_us: u32,
    /// Every request of the protocol and its reply, for [`RequestMix::Any`].
    pub any_request: Requests,
    /// The bit rates that the drives know.
    pub bit_rates: &'static [BitRate],
    /// An identifier that one of the drives and a CANopen device would both take for theirs.
    pub clash: Option<Clash>,
}
