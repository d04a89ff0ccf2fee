//! One bus of a log: a log may hold several interfaces, and identifiers mean something on their own bus only.

use can_decode::log::{Entry, Event};
use can_decode::statistics::Statistics;
use can_decode::{Decoder, Frame, Meaning};

use super::log_motion::LogMotion;

/// What was heard on one interface.
#[derive(Debug)]
pub(super) struct Bus {
    pub(super) interface: String,
    pub(super) statistics: Statistics,
    /// Frames that are no message of any protocol.
    pub(super) undecodable: u64,
    /// Messages that look like trouble, those that do not decode included.
    pub(super) remarkable: u64,
    pub(super) error_frames: u64,
    pub(super) fd_frames: u64,
    decoder: Decoder,
    latest_ns: u64,
    /// Entries before the latest one in time.
    pub(super) times_back: u64,
    /// The motion in the log, when a page of it is wanted.
    pub(super) motion: Option<LogMotion>,
}

/// What an entry of a log says.
#[derive(Debug)]
pub(super) enum Said<'a> {
    /// A frame and its meaning.
    Frame(&'a Frame, Meaning),
    /// Something else.
    Other(&'static str),
}

impl Bus {
    pub(super) fn new(interface: &str, decoder: Decoder) -> Self {
        Self {
            interface: interface.to_owned(),
            statistics: Statistics::default(),
            undecodable: 0,
            remarkable: 0,
            error_frames: 0,
            fd_frames: 0,
            decoder,
            latest_ns: 0,
            times_back: 0,
            motion: None,
        }
    }

    /// The time of the latest entry, when this one comes before it.
    pub(super) fn goes_back_from(&mut self, at_ns: u64) -> Option<u64> {
        let before_ns = core::mem::replace(&mut self.latest_ns, at_ns);
        self.times_back += u64::from(at_ns < before_ns);
        (at_ns < before_ns).then_some(before_ns)
    }

    pub(super) fn hear<'a>(&mut self, entry: &'a Entry<'_>) -> Said<'a> {
        match &entry.event {
            Event::Frame(frame) => {
                let meaning = self.decoder.hear(entry.at_ns, frame);
                self.statistics.count(entry.at_ns, frame, &meaning);
                self.undecodable += u64::from(meaning.is_undecodable());
                self.remarkable += u64::from(meaning.is_remarkable());
                if let (Some(motion), Some(at_ns)) = (&mut self.motion, entry.at_ns) {
                    motion.frame(at_ns, frame, &meaning);
                }
                Said::Frame(frame, meaning)
            }
            Event::ErrorFrame => {
                self.error_frames += 1;
                if let (Some(motion), Some(at_ns)) = (&mut self.motion, entry.at_ns) {
                    motion.error_frame(at_ns);
                }
                Said::Other("error frame: a node saw an error on the bus")
            }
            Event::OverloadFrame => Said::Other("overload frame: a node asked for a pause"),
            Event::ControllerState => {
                Said::Other("the controller told its state: see the log for warnings and bus off")
            }
            Event::FdFrame => {
                self.fd_frames += 1;
                Said::Other("CAN FD frame: not for a classic bus")
            }
            _ => Said::Other("an event that is no frame"),
        }
    }
}
