//! Links to a real bus: CAN adapters that this computer sees as a serial port or as a network interface.
//!
//! A [`Link`] is what a CAN driver is on a board: it implements `embedded_can::nb::Can`, and the master is driven over it
//! by the same `can_motion::service`. In addition it can wait, and it remembers the fault that made it unusable.

mod buses;
mod byte_port;
mod channel;
mod error;
#[cfg(test)]
pub(crate) mod fake_adapter;
mod fault;
mod options;
mod pcan;
mod slcan;
#[cfg(target_os = "linux")]
mod socket_can;

use core::fmt::Debug;
use std::time::Duration;

use can_motion::plan::BitRate;
use drive_sim::Frame;
use embedded_can::nb::Can;

pub(crate) use buses::{BusesOptions, OpenBus};
pub(crate) use byte_port::BytePort;
pub(crate) use error::OpenError;
pub(crate) use fault::LinkFault;
pub(crate) use options::{
    LinkOptions, PortOptions, SpeedOptions, listen_to_interface, listen_to_slcan,
};
pub(crate) use pcan::is_interface;
pub(crate) use slcan::ANSWER_LIMIT;

/// An open link to a bus.
#[derive(Debug)]
pub(crate) struct Link {
    adapter: Box<dyn Adapter>,
    bit_rate: BitRate,
    /// Frames in both directions since they were taken last, when somebody records them.
    passed: Option<Vec<Passed>>,
    /// The next frame is one at which this program panics.
    #[cfg(test)]
    pub(crate) panics: std::sync::Arc<std::sync::atomic::AtomicBool>,
}

/// A frame that the link took or received.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    pub(crate) at: std::time::Instant,
    pub(crate) frame: Frame,
    pub(crate) was_sent: bool,
}

/// A driver of one kind of adapters.
trait Adapter: Can<Frame = Frame, Error = LinkFault> + Debug + Send {
    /// Waits until something may have come in, at most so long. Returns at once when the link has failed.
    fn wait(&mut self, most: Duration);

    /// The fault after which nothing gets through any more.
    fn fault(&self) -> Option<LinkFault>;

    /// The number of frames since the last call of which nobody knows whether they went out.
    fn take_unknown(&mut self) -> usize {
        0
    }

    /// Whether the adapter acknowledges no frame, so that nobody knows of those that it drops.
    fn is_silent(&self) -> bool {
        false
    }
}

impl Link {
    fn new(adapter: Box<dyn Adapter>, kbit_per_s: u32) -> Self {
        Self {
            adapter,
            // Listeners may use rates that no drive knows, and they plan nothing.
            bit_rate: BitRate::from_kbit_per_s(kbit_per_s).unwrap_or(BitRate::Kbit1000),
            passed: None,
            #[cfg(test)]
            panics: std::sync::Arc::default(),
        }
    }

    /// The bit rate of the bus, as the user has told it.
    pub(crate) fn bit_rate(&self) -> BitRate {
        self.bit_rate
    }

    /// From now on every frame is kept until it is taken.
    pub(crate) fn keep_frames(&mut self) {
        self.passed.get_or_insert_default();
    }

    /// The frames that passed since the last call, in both directions.
    pub(crate) fn take_frames(&mut self) -> Vec<Passed> {
        self.passed
            .as_mut()
            .map(core::mem::take)
            .unwrap_or_default()
    }

    fn note(&mut self, frame: Frame, was_sent: bool) {
        if let Some(passed) = &mut self.passed {
            passed.push(Passed {
                at: std::time::Instant::now(),
                frame,
                was_sent,
            });
        }
    }

    /// Waits until something may have come in, at most so long. Returns at once when the link has failed.
    pub(crate) fn wait(&mut self, most: Duration) {
        self.adapter.wait(most)
    }

    /// The fault after which nothing gets through any more.
    pub(crate) fn fault(&self) -> Option<LinkFault> {
        self.adapter.fault()
    }
}

impl Link {
    /// The number of frames since the last call of which nobody knows whether they went out, because the adapter did not answer for
    /// them.
    pub(crate) fn take_unknown(&mut self) -> usize {
        self.adapter.take_unknown()
    }

    /// Whether the adapter acknowledges no frame, so that nobody knows of those that it drops.
    pub(crate) fn is_silent(&self) -> bool {
        self.adapter.is_silent()
    }
}

impl Can for Link {
    type Frame = Frame;
    type Error = LinkFault;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, LinkFault> {
        #[cfg(test)]
        assert!(
            !self
                .panics
                .swap(false, std::sync::atomic::Ordering::Relaxed),
            "a test asked for it"
        );
        let displaced = self.adapter.transmit(frame)?;
        self.note(*frame, true);
        Ok(displaced)
    }

    fn receive(&mut self) -> nb::Result<Frame, LinkFault> {
        let frame = self.adapter.receive()?;
        self.note(frame, false);
        Ok(frame)
    }
}
