//! Which CANopen nodes are there: each is asked for its device type and, when it answers, for its software version.
//!
//! Reading changes nothing. Every node has a client of its own, so that a late answer of one is never taken for that of another.

use can_motion::{BusErrorKind, BusUser, Instant, Outcome, Progress, Sink};
use zlac8030l::{
    DataFrame, FrameError, NodeId, ObjectValue, SdoClient, SdoEnd, SdoEvent, SdoHeard, SdoRequest,
    SdoTimeouts, objects,
};

use crate::drives::{DrivesError, FoundDrive};
use crate::link::Link;
use crate::station::{Clock, StallWatch, serve_until};

/// How often the scan is told that time passes, in microseconds.
const TICK_US: u32 = 1_000;

/// How long each node has to answer: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
const LISTEN_US: u32 = 50_000;

/// Asks every node on the bus behind a link.
///
/// # Errors
/// [`DrivesError::Link`] when the link fails, [`DrivesError::NothingGetsOut`] when nobody takes a frame.
pub(super) fn scan(
    link: &mut Link,
    on_node: &mut dyn FnMut(u8),
) -> Result<Vec<FoundDrive>, DrivesError> {
    let clock = Clock::start();
    let mut scan = NodeScan::listening(LISTEN_US);
    let mut watch = StallWatch::new(scan.node(), clock.now());
    loop {
        if let Some(found) = scan.result() {
            return Ok(found.iter().map(FoundNode::as_drive).collect());
        }
        on_node(scan.node().get());
        let until = clock.now() + TICK_US;
        serve_until(&mut scan, link, &clock, until)?;
        scan.tick(clock.now());
        if watch.stalls_at(scan.node(), clock.now()) {
            return Err(DrivesError::NothingGetsOut);
        }
    }
}

/// Device type of a servo drive.
const CIA_402_SERVO: u32 = 0x0004_0192;

/// A node that answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FoundNode {
    node: NodeId,
    /// 1000h; 40192h is a servo drive after CiA 402.
    device_type: Option<u32>,
    /// 2025h.
    software_version: Option<u16>,
}

impl FoundNode {
    fn as_drive(&self) -> FoundDrive {
        let device = match self.device_type {
            Some(CIA_402_SERVO) => "servo drive (CiA 402)".to_owned(),
            Some(other) => format!("device type {other:08X}h"),
            None => "device type not told".to_owned(),
        };
        let software = self.software_version.map_or(String::new(), |version| {
            format!(", software {version:04X}h")
        });
        FoundDrive {
            drive: self.node.get(),
            protocol: format!("CANopen {device}{software}"),
        }
    }
}

/// What is asked of the present node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    DeviceType,
    SoftwareVersion,
}

impl Question {
    const fn request(self) -> SdoRequest {
        match self {
            Self::DeviceType => objects::DEVICE_TYPE.read(),
            Self::SoftwareVersion => objects::SOFTWARE_VERSION.read(),
        }
    }
}

/// Asks one node after the other. Sans-I/O, like everything that uses the bus.
#[derive(Debug)]
struct NodeScan {
    timeouts: SdoTimeouts,
    client: SdoClient,
    question: Question,
    /// The controller has the question; its answer is awaited.
    is_asked: bool,
    /// The abort of a question that was given up.
    abort: Option<DataFrame>,
    found: Vec<FoundNode>,
    is_over: bool,
}

/// A question, or an abort.
#[derive(Debug, Clone, Copy)]
struct Ask {
    frame: DataFrame,
    is_abort: bool,
}

impl NodeScan {
    /// A scan of nodes 1 to 127 that gives each `reply_us` to answer.
    const fn listening(reply_us: u32) -> Self {
        let timeouts = SdoTimeouts {
            reply_us,
            ..SdoTimeouts::DEFAULT
        };
        Self {
            timeouts,
            client: SdoClient::new(NodeId::MIN, timeouts),
            question: Question::DeviceType,
            is_asked: false,
            abort: None,
            found: Vec::new(),
            is_over: false,
        }
    }

    /// The node that is asked now.
    const fn node(&self) -> NodeId {
        self.client.node()
    }

    /// The nodes that answered, once every one was asked.
    fn result(&self) -> Option<&[FoundNode]> {
        (self.is_over && self.abort.is_none()).then_some(&self.found)
    }

    /// Lets time pass.
    fn tick(&mut self, now: Instant) {
        if let Some(event) = self.client.poll(now.as_us()) {
            self.ended(event);
        }
    }

    fn ended(&mut self, event: SdoEvent) {
        let node = self.node();
        self.abort = event.abort().map(|abort| abort.encode(node));
        self.is_asked = false;
        let value = match event.end {
            SdoEnd::Value(data) => Some(data),
            _ => None,
        };
        match self.question {
            // Silence: nobody is there. A refusal is an answer.
            Question::DeviceType if event.end == SdoEnd::TimedOut => self.next_node(),
            Question::DeviceType => {
                self.found.push(FoundNode {
                    node,
                    device_type: value.and_then(|data| u32::from_data(data).ok()),
                    software_version: None,
                });
                self.question = Question::SoftwareVersion;
            }
            Question::SoftwareVersion => {
                if let Some(found) = self.found.last_mut() {
                    found.software_version = value.and_then(|data| u16::from_data(data).ok());
                }
                self.next_node();
            }
        }
    }

    fn next_node(&mut self) {
        self.question = Question::DeviceType;
        match NodeId::all().find(|node| *node > self.node()) {
            Some(node) => self.client = SdoClient::new(node, self.timeouts),
            None => self.is_over = true,
        }
    }
}

impl NodeScan {
    fn next_ask(&self) -> Option<Ask> {
        if let Some(frame) = self.abort {
            return Some(Ask {
                frame,
                is_abort: true,
            });
        }
        let is_free = !self.is_over && !self.is_asked;
        is_free.then(|| Ask {
            frame: self.question.request().encode(self.node()),
            is_abort: false,
        })
    }

    fn accepted(&mut self, now: Instant, ask: &Ask) {
        if ask.is_abort {
            self.abort = None;
        } else {
            self.is_asked = self
                .client
                .start(now.as_us(), self.question.request())
                .is_ok();
        }
    }
}

impl BusUser for NodeScan {
    type Frame = DataFrame;

    fn send<S: Sink<DataFrame>>(&mut self, now: Instant, sink: &mut S) -> Progress {
        while let Some(ask) = self.next_ask() {
            match sink.offer(&ask.frame) {
                Outcome::Accepted => self.accepted(now, &ask),
                Outcome::Displaced(frame) => {
                    self.accepted(now, &ask);
                    self.on_displaced(now, &frame);
                }
                Outcome::Full => return Progress::Blocked,
                // Whether it goes out is not known: its answer is awaited.
                Outcome::Failed(_) => {
                    self.accepted(now, &ask);
                    return Progress::Idle;
                }
            }
        }
        Progress::Idle
    }

    fn on_displaced(&mut self, _: Instant, _: &DataFrame) {
        self.client.withdraw();
        self.is_asked = false;
    }

    fn on_receive_error(&mut self, _: Instant, _: BusErrorKind) {}

    fn on_frame(&mut self, now: Instant, frame: &DataFrame) {
        if let SdoHeard::Ended(event) = self.client.on_frame(now.as_us(), frame) {
            self.ended(event);
        }
    }

    fn on_foreign_frame(&mut self, _: Instant, _: FrameError) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use drive_sim::{Bench, BitRate, ControllerConfig, TxOrder, ZlacDriveConfig};

    #[test]
    fn every_node_that_answers_is_found_and_nothing_is_written() {
        let node = |number| NodeId::new(number).unwrap();
        let configs = [1, 4, 127].map(|number| ZlacDriveConfig::new(node(number)));
        let (mut bench, drives) = Bench::with_zlac_drives(BitRate::Kbit500, configs);
        let master = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        // The drives have started.
        bench.advance_to(200_000_000);
        let mut scan = NodeScan::listening(10_000);
        for _ in 0..20_000 {
            let now = Instant::from_us(bench.now_ns() / 1_000);
            let _ = can_motion::service(&mut scan, &mut bench.port(master), now);
            scan.tick(now);
            bench.advance_to(bench.now_ns() + 100_000);
        }
        let found = scan.result().expect("it ends");
        let nodes: Vec<u8> = found.iter().map(|found| found.node.get()).collect();
        assert_eq!(nodes, [1, 4, 127]);
        for found in found {
            let words = found.as_drive().protocol;
            assert_eq!(words, "CANopen servo drive (CiA 402), software 0021h");
        }
        for drive in drives {
            assert_eq!(bench.device(drive).eeprom_wear(), Default::default());
            assert_eq!(bench.device(drive).books().sdo_served, 2);
        }
    }
}
