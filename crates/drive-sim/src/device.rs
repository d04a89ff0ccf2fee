//! A simulated device on the bus.
//!
//! Specification: a device learns of a frame at the end of that frame and never earlier, and acts only at instants that it has announced.

use crate::frame::Frame;

/// A device, such as a simulated drive. A [`Bench`](crate::Bench) runs it.
pub trait Device {
    /// A frame that its controller has received at `now_ns`. Whatever it provokes is sent from [`Self::run`], now or later.
    fn on_frame(&mut self, now_ns: u64, frame: &Frame);

    /// When it wants to run next, if at all. The bench asks after every [`Self::on_frame`] and [`Self::run`]; an instant in the past means now.
    fn next_event_ns(&self) -> Option<u64>;

    /// Does what is due at `now_ns` and hands frames to `transmit`.
    ///
    /// It runs once at an instant: if it then asks for an instant that is not later than `now_ns`, it runs again a nanosecond later.
    fn run(&mut self, now_ns: u64, transmit: &mut dyn FnMut(Frame));
}

impl<D: Device + ?Sized> Device for Box<D> {
    fn on_frame(&mut self, now_ns: u64, frame: &Frame) {
        (**self).on_frame(now_ns, frame);
    }

    fn next_event_ns(&self) -> Option<u64> {
        (**self).next_event_ns()
    }

    fn run(&mut self, now_ns: u64, transmit: &mut dyn FnMut(Frame)) {
        (**self).run(now_ns, transmit);
    }
}
