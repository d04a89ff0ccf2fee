//! Waiting times of the client.

use core::num::NonZeroU8;

use crate::packet::MAX_PACKET;

/// Microseconds of a byte at 38400 baud, 8N1 (manual section 7.1: about 260 us).
pub const BYTE_US: u32 = 261;

/// Waiting times and repetitions. No document has figures, but for the 10 to 20 ms that the sample code waits for a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timing {
    /// The line must have been quiet for so long before a request is sent.
    pub quiet_us: u32,
    /// The longest wait for a quiet line.
    pub quiet_timeout_us: u32,
    /// After a packet was sent, its echo is listened for so long before the next one is sent, and as long after the start (time 0) for
    /// what others have left on the line. Longer than a converter holds bytes back, so that an echo does not come in place of a reply.
    pub echo_us: u32,
    /// The longest wait for a reply, counted from when its request was handed over. It must be longer than any reply takes:
    /// replies have no number, and one that comes later can be taken for the reply to a repetition, or to the next request
    /// of the same function to the same drive.
    pub reply_timeout_us: u32,
    /// How often a read is sent at most.
    pub attempts: NonZeroU8,
}

impl Timing {
    /// One drive at the port: quiet for 2 ms within 100 ms, echoes within 2 ms, replies within 50 ms, three attempts.
    pub const ONE_DRIVE: Self = Self {
        quiet_us: 2_000,
        quiet_timeout_us: 100_000,
        echo_us: 2_000,
        reply_timeout_us: 50_000,
        attempts: NonZeroU8::MIN.saturating_add(2),
    };

    /// A chain of drives, each of which passes on what is not for itself (section 7.8): every further drive may hold back
    /// a whole packet on the way there and another on the way back.
    #[must_use]
    pub const fn chain(drives: NonZeroU8) -> Self {
        let relays = drives.get() as u32 - 1;
        let packet_us = MAX_PACKET as u32 * BYTE_US;
        Self {
            quiet_us: Self::ONE_DRIVE.quiet_us + relays * packet_us,
            quiet_timeout_us: Self::ONE_DRIVE.quiet_timeout_us + 2 * relays * packet_us,
            echo_us: Self::ONE_DRIVE.echo_us + 2 * relays * packet_us,
            reply_timeout_us: Self::ONE_DRIVE.reply_timeout_us + 2 * relays * packet_us,
            ..Self::ONE_DRIVE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_further_drive_of_a_chain_may_hold_back_a_packet_on_each_way() {
        let chain = |drives| Timing::chain(NonZeroU8::new(drives).unwrap());
        assert_eq!(chain(1), Timing::ONE_DRIVE);
        // Two further drives, 7 bytes of 261 us each: 3654 us one way, 7308 us both ways.
        let three = Timing {
            quiet_us: 5_654,
            quiet_timeout_us: 107_308,
            echo_us: 9_308,
            reply_timeout_us: 57_308,
            ..Timing::ONE_DRIVE
        };
        assert_eq!(chain(3), three);
    }
}
