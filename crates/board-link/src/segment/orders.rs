//! Orders to a stream under way: pause, resume, another speed, stop.

use super::admission::Admission;
use super::checks::override_rate;
use super::queue::Order;
use crate::reason::Reason;
use crate::refused::Refused;

impl<const AXES: usize> Admission<'_, AXES> {
    /// Slows down to a standstill on the path, and waits.
    ///
    /// # Errors
    /// [`Reason::NoStream`], [`Reason::Busy`].
    pub fn pause(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Pause)
    }

    /// Goes on.
    ///
    /// # Errors
    /// As [`Self::pause`].
    pub fn resume(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Resume)
    }

    /// Another speed, 0 to 200 %. Where the limits of an axis allow less, it is held to that.
    ///
    /// # Errors
    /// [`Reason::Override`], or as [`Self::pause`].
    pub fn set_override(&mut self, percent: u16) -> Result<(), Refused> {
        let rate = override_rate(percent)?;
        self.check_active()?;
        self.order(Order::Override(rate))
    }

    /// Slows down to a standstill on the path, and ends; nothing is taken any more.
    ///
    /// # Errors
    /// As [`Self::pause`].
    pub fn stop(&mut self) -> Result<(), Refused> {
        self.check_active()?;
        self.order(Order::Stop)?;
        self.stream.is_stopping = true;
        Ok(())
    }

    fn check_active(&self) -> Result<(), Refused> {
        if self.player().phase.is_active() {
            return Ok(());
        }
        Err(Reason::NoStream.because(0, self.stream.number.into()))
    }
}
