//! A bus that is there now, as a source of frames.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use can_decode::Frame;
use can_decode::log::{Entry, Event};
use embedded_can::nb::Can;

use super::error::DecodeError;
use super::source::{Heard, Source};
use crate::interrupt;
use crate::link::{Link, OpenError};

/// The longest wait, so that Ctrl-C is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(50);

/// Frames as they come in, with the time of this computer. It sends nothing.
pub(crate) struct LiveBus {
    name: String,
    link: Link,
    start: Instant,
    /// Since 1970, at `start`: later times follow a clock that nobody sets.
    start_ns: u64,
    number: u64,
}

impl LiveBus {
    /// Listens to a link until Ctrl-C.
    pub(crate) fn new(name: &str, link: Result<Link, OpenError>) -> Result<Self, DecodeError> {
        let link = link.map_err(DecodeError::Open)?;
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
        Ok(Self {
            name: name.to_owned(),
            link,
            start: Instant::now(),
            start_ns: since_1970.map_or(0, nanoseconds),
            number: 0,
        })
    }

    /// What came next; `None` when the user asks to stop.
    fn wait_for_event(&mut self) -> Result<Option<Event>, DecodeError> {
        while interrupt::requests() == 0 {
            match self.link.receive() {
                Ok(frame) => {
                    // Every frame of a classic bus is one for the decoder.
                    if let Some(frame) = Frame::from_can(&frame) {
                        return Ok(Some(Event::Frame(frame)));
                    }
                }
                Err(nb::Error::WouldBlock) => self.link.wait(LONGEST_WAIT),
                Err(nb::Error::Other(fault)) if fault.is_final() => {
                    return Err(DecodeError::Link(fault));
                }
                Err(nb::Error::Other(_)) => return Ok(Some(Event::ErrorFrame)),
            }
        }
        Ok(None)
    }
}

impl Source for LiveBus {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn may_wait(&self) -> bool {
        true
    }

    fn next(&mut self) -> Result<Option<Heard<'_>>, DecodeError> {
        let Some(event) = self.wait_for_event()? else {
            return Ok(None);
        };
        self.number += 1;
        let since_start_ns = nanoseconds(self.start.elapsed());
        let entry = Entry {
            at_ns: Some(self.start_ns.saturating_add(since_start_ns)),
            interface: &self.name,
            event,
        };
        Ok(Some(Heard {
            line: self.number,
            what: Ok(Some(entry)),
        }))
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::LinkFault;
    use crate::link::fake_adapter::{FakeAdapter, set_up_answer};

    #[test]
    fn frames_come_in_order_until_the_adapter_is_gone() {
        let mut adapter = FakeAdapter::new("listen", |line| match line {
            b"L" => b"\rt0290\rt029100\r".to_vec(),
            b"O" => panic!("a listener must not acknowledge"),
            line => set_up_answer(line),
        });
        let mut bus = LiveBus::new("adapter", adapter.listen()).unwrap();
        let mut heard = Vec::new();
        for _ in 0..2 {
            let Some(Heard { line, what }) = bus.next().unwrap() else {
                panic!("nobody asked to stop");
            };
            let entry = what.unwrap().unwrap();
            heard.push((line, entry.interface.to_owned(), entry.event));
        }
        let event = |data: &[u8]| Event::Frame(Frame::new(0x029, false, data).unwrap());
        let interface = || "adapter".to_owned();
        assert_eq!(
            heard,
            [(1, interface(), event(&[])), (2, interface(), event(&[0]))]
        );
        adapter.vanish();
        assert!(matches!(
            bus.next(),
            Err(DecodeError::Link(LinkFault::Vanished))
        ));
    }
}
