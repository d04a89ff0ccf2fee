//! The transmit FIFO: requests in their order, and cancellation (RM0440, section 44.3.6).

use std::collections::VecDeque;

/// Places of the FIFO.
pub(super) const PLACES: usize = 3;
/// From the request to cancel a frame that is not on the wire until it has happened: some clocks, as in bxCAN.
const CANCEL_NS: u64 = 50;

/// The FIFO with its registers.
#[derive(Debug, Clone, Default)]
pub(super) struct TransmitFifo {
    /// Places in the order of request.
    order: VecDeque<usize>,
    put: usize,
    sent: u32,
    cancelled: u32,
    cancels_ns: [Option<u64>; PLACES],
}

impl TransmitFifo {
    /// Places with a frame that waits, the next to go first.
    pub(super) fn waiting(&self) -> impl Iterator<Item = usize> + '_ {
        self.order.iter().copied()
    }

    /// Whether a place has a frame that waits.
    pub(super) fn is_pending(&self, place: usize) -> bool {
        self.order.contains(&place)
    }

    /// TXBRP.
    pub(super) fn pending(&self) -> u32 {
        self.waiting().fold(0, |bits, place| bits | 1 << place)
    }

    /// TXBTO and TXBCF.
    pub(super) fn finished(&self) -> [u32; 2] {
        [self.sent, self.cancelled]
    }

    /// TXFQS.
    pub(super) fn status(&self) -> u32 {
        let get = self.waiting().next().unwrap_or(self.put);
        let free = PLACES - self.order.len();
        let is_full = self.is_pending(self.put);
        free as u32 | (get as u32) << 8 | (self.put as u32) << 16 | u32::from(is_full) << 21
    }

    /// Writes TXBAR.
    pub(super) fn request(&mut self, value: u32) {
        for place in (0..PLACES).filter(|place| value >> place & 1 != 0) {
            if !self.is_pending(place) {
                self.order.push_back(place);
                self.sent &= !(1 << place);
                self.cancelled &= !(1 << place);
                self.put = (place + 1) % PLACES;
            }
        }
    }

    /// Writes TXBCR.
    pub(super) fn request_cancellation(&mut self, value: u32, now_ns: u64) {
        for place in (0..PLACES).filter(|place| value >> place & 1 != 0) {
            if self.is_pending(place) {
                self.cancels_ns[place].get_or_insert(now_ns + CANCEL_NS);
            }
        }
    }

    /// When the next request to cancel takes effect.
    pub(super) fn next_cancel_ns(&self) -> Option<u64> {
        self.cancels_ns.iter().flatten().copied().min()
    }

    /// Places that still wait and whose request to cancel takes effect by then.
    pub(super) fn take_due(&mut self, due_ns: u64) -> Vec<usize> {
        let is_due = |at_ns: &mut Option<u64>| at_ns.take_if(|at_ns| *at_ns <= due_ns).is_some();
        let due: Vec<usize> = (0..PLACES)
            .filter(|&place| is_due(&mut self.cancels_ns[place]))
            .collect();
        due.into_iter()
            .filter(|&place| self.is_pending(place))
            .collect()
    }

    /// A frame went out.
    pub(super) fn finish_sent(&mut self, place: usize) {
        self.order.retain(|&other| other != place);
        self.sent |= 1 << place;
    }

    /// A frame was given up.
    pub(super) fn finish_cancelled(&mut self, place: usize) {
        self.order.retain(|&other| other != place);
        self.cancelled |= 1 << place;
    }
}
