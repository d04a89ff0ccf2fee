//! The frames of one drive, as its family describes them.

use can_frame::wire::INTERFRAME_BITS;

use crate::analysis::max;

/// Requests with which a drive may be asked, and their replies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Requests {
    /// Requests due in a cycle, in millionths.
    pub(crate) due_ppm: u64,
    /// The longest request.
    pub(crate) request_bits: u64,
    /// The shortest request without its interframe space.
    pub(crate) shortest_request_bits: u64,
    /// The longest reply.
    pub(crate) reply_bits: u64,
}

impl Requests {
    /// A drive that is not asked.
    pub const NONE: Self = Self {
        due_ppm: 0,
        request_bits: 0,
        shortest_request_bits: u16::MAX as u64,
        reply_bits: 0,
    };

    /// Requests without a period. Lengths in bits, interframe space included.
    #[must_use]
    pub const fn any(shortest_request_bits: u16, request_bits: u16, reply_bits: u16) -> Self {
        Self {
            due_ppm: 0,
            request_bits: request_bits as u64,
            shortest_request_bits: shortest_request_bits.saturating_sub(INTERFRAME_BITS) as u64,
            reply_bits: reply_bits as u64,
        }
    }

    /// One more, whose length is known, every `period_us`; the master counts in whole cycles, at least one.
    #[must_use]
    pub const fn and(
        self,
        period_us: u32,
        cycle_us: u32,
        request_bits: u16,
        reply_bits: u16,
    ) -> Self {
        let cycles = match period_us.checked_div(cycle_us) {
            Some(cycles) => max(cycles as u64, 1),
            None => 1,
        };
        let more = Self {
            due_ppm: 1_000_000_u64.div_ceil(cycles),
            ..Self::any(request_bits, request_bits, reply_bits)
        };
        self.with(&more)
    }

    pub(crate) const fn with(self, more: &Self) -> Self {
        let shortest_request_bits = if more.shortest_request_bits < self.shortest_request_bits {
            more.shortest_request_bits
        } else {
            self.shortest_request_bits
        };
        Self {
            due_ppm: self.due_ppm + more.due_ppm,
            request_bits: max(self.request_bits, more.request_bits),
            shortest_request_bits,
            reply_bits: max(self.reply_bits, more.reply_bits),
        }
    }

    pub(crate) const fn is_none(&self) -> bool {
        self.request_bits == 0
    }
}

/// A drive and its frames, each at its longest, in bits with the interframe space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Drive {
    /// Number by which messages name it. A list of drives is in ascending order of their numbers.
    pub number: u8,
    /// Drives of different groups are brought up while others stream.
    pub group: u8,
    /// The least urgent of its identifiers.
    pub last_id: u16,
    /// The frame that the master sends it in each cycle.
    pub set_point_bits: u16,
    /// With what it is asked while set-points are streamed.
    pub polls: Requests,
    /// The frame that it sends unasked when something is wrong.
    pub alarm_bits: u16,
}

impl Drive {
    /// A drive of group 0 that is sent nothing and sends nothing.
    #[must_use]
    pub const fn silent(number: u8, last_id: u16) -> Self {
        Self {
            number,
            group: 0,
            last_id,
            set_point_bits: 0,
            polls: Requests::NONE,
            alarm_bits: 0,
        }
    }
}
