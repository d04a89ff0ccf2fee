//! A frame with its time.

use can_decode::Frame;

/// One attempt on the wire, or a frame as this computer handed it over or received it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WireFrame {
    /// Start of frame since the start of the recording; worked out from the end where only that is known.
    pub(crate) start_ns: u64,
    /// End of the frame. On a real bus: when the link took it, or when this computer received it.
    pub(crate) end_ns: u64,
    /// Length on the wire; the least that it can have where it is not known.
    pub(crate) bits: u32,
    pub(crate) frame: Frame,
    /// The master sent it; `None` in a log.
    pub(crate) from_master: Option<bool>,
    /// How the attempt failed.
    pub(crate) failure: Option<&'static str>,
    /// Whether anybody received it.
    pub(crate) is_received: bool,
}

impl WireFrame {
    /// A frame of which only the end is known.
    pub(crate) fn ended(end_ns: u64, frame: Frame, from_master: Option<bool>, bit_ns: u64) -> Self {
        let bits = frame.least_bits();
        Self {
            start_ns: end_ns.saturating_sub(u64::from(bits) * bit_ns),
            end_ns,
            bits,
            frame,
            from_master,
            failure: None,
            is_received: true,
        }
    }
}
