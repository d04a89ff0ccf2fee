//! Waiting times.

/// Waiting times in microseconds, each with the reason for its default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timeouts {
    /// From the start to the first request. The manual states 150 ms after power-on for pulse and analog commands;
    /// applied to CAN too (D58).
    pub power_on_us: u32,
    /// From a request to the end of waiting for its reply. The documents lost their figure (D65): 10 ms is longer than
    /// the worst response and queueing that were measured. After it the drive is not asked again for the same time.
    pub reply_us: u32,
    /// After a reply, before the next request to the same drive: a frame that CAN repeats follows at once, so one
    /// millisecond is enough to recognise it.
    pub settle_us: u32,
    /// After the first alarm frame of a drive, before the next request to any drive. Repeated alarm frames do not prolong it.
    pub alarm_quiet_us: u32,
    /// Without a step for this long, an axis should have arrived: from then on the drift tolerance applies.
    pub arrival_us: u32,
    /// The shaft must have stood still this long before enabling (D59; the documents lost their figure).
    pub standstill_us: u32,
    /// How long to wait for that standstill.
    pub standstill_limit_us: u32,
    /// From the enable or disable command to its confirmation in the status byte. A disable command is repeated after it.
    pub confirm_us: u32,
    /// For so long no set-point of an axis may get out before its group stops: then the bus is blocked or nobody is on it. At least
    /// five cycles are allowed in any case.
    pub stuck_us: u32,
    /// Timeouts in a row after which a drive is lost.
    pub lost_after: u8,
}

impl Timeouts {
    /// The defaults explained at each field.
    pub const DEFAULT: Self = Self {
        power_on_us: 150_000,
        reply_us: 10_000,
        settle_us: 1_000,
        alarm_quiet_us: 20_000,
        arrival_us: 200_000,
        standstill_us: 150_000,
        standstill_limit_us: 5_000_000,
        confirm_us: 200_000,
        stuck_us: 20_000,
        lost_after: 3,
    };
}

impl Default for Timeouts {
    fn default() -> Self {
        Self::DEFAULT
    }
}
