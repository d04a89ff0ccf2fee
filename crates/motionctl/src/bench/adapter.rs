//! A Lawicel adapter: commands in, answers and received frames out. The controller that it drives is a node of the
//! virtual bus.
//!
//! Answers follow the CAN232 manual, version 3, with automatic polling as the CANUSB has it. Acceptance filters (`M`, `m`),
//! polling by hand (`P`, `A`, `X`) and bit timing registers (`s`) are refused with BEL, as by an adapter without them.

use drive_sim::{Bench, Device, Frame, NodeId};
use embedded_can::Frame as _;
use embedded_can::nb::Can;

use crate::lawicel::{self, BEL, CR, Lines, Token};

/// Frames that wait in the adapter to be sent; one more is refused.
const TX_FRAMES: usize = 32;
/// Bytes that wait in the adapter for the host; a received frame that does not fit is lost.
const RX_BYTES: usize = 4_096;
/// The same for answers, which have twice the room: a host that reads at all gets each of them.
const MOST_TO_HOST: usize = 2 * RX_BYTES;
/// The time stamp counts milliseconds and starts anew after a minute.
const STAMP_MS: u64 = 60_000;

/// Version of hardware 1.0 and software 1.3, as the manual shows it.
const VERSION: &[u8] = b"V1013";
/// A serial number that no device has.
const SERIAL_NUMBER: &[u8] = b"NVIRT";

/// Bits of the status flags (`F`).
mod flag {
    pub(super) const TX_FULL: u8 = 1 << 1;
    pub(super) const ERROR_WARNING: u8 = 1 << 2;
    pub(super) const OVERRUN: u8 = 1 << 3;
    pub(super) const ERROR_PASSIVE: u8 = 1 << 5;
    pub(super) const BUS_ERROR: u8 = 1 << 7;
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    Closed,
    Open,
    ListenOnly,
}

/// A command that the adapter refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Refused;

/// What an adapter did not do, since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Refusals {
    /// Frames of the host that it did not take: malformed, channel not open for sending, or no room.
    pub(crate) frames: u64,
    /// Other lines of the host that it did not obey.
    pub(crate) commands: u64,
    /// Frames and answers for which the host was too slow.
    pub(crate) lost_to_host: u64,
}

/// The adapter.
#[derive(Debug)]
pub(crate) struct Adapter {
    node: NodeId,
    lines: Lines,
    channel: Channel,
    kbit_per_s: Option<u32>,
    stamps: bool,
    flags: u8,
    /// Frames that never leave, because the adapter has another bit rate than the bus.
    stuck: usize,
    outbox: Vec<u8>,
    refusals: Refusals,
}

impl Adapter {
    /// An adapter on a node of the bus, closed and without a bit rate.
    pub(crate) fn new<D: Device>(bench: &mut Bench<D>, node: NodeId) -> Self {
        bench.port(node).power_off();
        Self {
            node,
            lines: Lines::default(),
            channel: Channel::Closed,
            kbit_per_s: None,
            stamps: false,
            flags: 0,
            stuck: 0,
            outbox: Vec::new(),
            refusals: Refusals::default(),
        }
    }

    /// What it did not do.
    pub(crate) fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// What waits for the host. Drain what the host has taken.
    pub(crate) fn outbox(&mut self) -> &mut Vec<u8> {
        &mut self.outbox
    }

    /// Bytes from the host.
    pub(crate) fn hear<D: Device>(&mut self, bytes: &[u8], bench: &mut Bench<D>) {
        self.lines.push(bytes);
        while let Some(token) = self.lines.pop() {
            let answer = match &token {
                Token::Line(line) => self.obey(line, bench),
                Token::Overlong => Err(Refused),
                // Not a command, and an answer to it could go back and forth for ever.
                Token::Bell => continue,
            };
            match answer {
                Ok(mut text) => {
                    text.push(CR);
                    self.tell(&text, MOST_TO_HOST);
                }
                Err(Refused) => {
                    self.count_refusal(&token);
                    self.tell(&[BEL], MOST_TO_HOST);
                }
            }
        }
    }

    fn count_refusal(&mut self, token: &Token) {
        let is_frame = matches!(token, Token::Line(line) if matches!(line.first(), Some(b't' | b'T' | b'r' | b'R')));
        let count = if is_frame {
            &mut self.refusals.frames
        } else {
            &mut self.refusals.commands
        };
        *count += 1;
    }

    /// Puts bytes into the queue to the host when they fit into its first `room` bytes.
    fn tell(&mut self, bytes: &[u8], room: usize) {
        if self.outbox.len() + bytes.len() > room {
            self.flags |= flag::OVERRUN;
            self.refusals.lost_to_host += 1;
        } else {
            self.outbox.extend_from_slice(bytes);
        }
    }

    /// Hands on what the node has received.
    pub(crate) fn hand_on<D: Device>(&mut self, bench: &mut Bench<D>) {
        while let Ok(frame) = bench.port(self.node).receive() {
            let mut line = lawicel::encode(&frame);
            if self.stamps {
                let ms = bench.now_ns() / 1_000_000 % STAMP_MS;
                line.push_str(&format!("{ms:04X}"));
            }
            line.push(char::from(CR));
            self.tell(line.as_bytes(), RX_BYTES);
        }
    }

    fn obey<D: Device>(&mut self, line: &[u8], bench: &mut Bench<D>) -> Result<Vec<u8>, Refused> {
        let Some((&letter, parameters)) = line.split_first() else {
            // An empty line clears the line of half a command.
            return Ok(Vec::new());
        };
        match (letter, parameters) {
            (b'S', [digit]) => self.set_bit_rate(*digit),
            (b'O', []) => self.open(Channel::Open, bench),
            (b'L', []) => self.open(Channel::ListenOnly, bench),
            (b'C', []) => self.close(bench),
            (b't' | b'T' | b'r' | b'R', _) => self.transmit(line, bench),
            (b'F', []) => self.read_flags(bench),
            (b'V', []) => Ok(VERSION.to_vec()),
            (b'N', []) => Ok(SERIAL_NUMBER.to_vec()),
            (b'Z', [digit @ (b'0' | b'1')]) if self.channel == Channel::Closed => {
                self.stamps = *digit == b'1';
                Ok(Vec::new())
            }
            _ => Err(Refused),
        }
    }

    fn set_bit_rate(&mut self, digit: u8) -> Result<Vec<u8>, Refused> {
        if self.channel != Channel::Closed {
            return Err(Refused);
        }
        self.kbit_per_s = Some(lawicel::kbit_per_s(digit).ok_or(Refused)?);
        Ok(Vec::new())
    }

    fn open<D: Device>(
        &mut self,
        channel: Channel,
        bench: &mut Bench<D>,
    ) -> Result<Vec<u8>, Refused> {
        if self.channel != Channel::Closed || self.kbit_per_s.is_none() {
            return Err(Refused);
        }
        self.channel = channel;
        if self.has_the_rate_of(bench) {
            bench.port(self.node).power_on();
        }
        Ok(Vec::new())
    }

    fn close<D: Device>(&mut self, bench: &mut Bench<D>) -> Result<Vec<u8>, Refused> {
        if self.channel == Channel::Closed {
            return Err(Refused);
        }
        self.channel = Channel::Closed;
        bench.port(self.node).power_off();
        (self.stuck, self.flags) = (0, 0);
        Ok(Vec::new())
    }

    fn transmit<D: Device>(
        &mut self,
        line: &[u8],
        bench: &mut Bench<D>,
    ) -> Result<Vec<u8>, Refused> {
        let frame = lawicel::decode(line).ok_or(Refused)?;
        // A command has no time stamp.
        if lawicel::encode(&frame).len() != line.len() || self.channel != Channel::Open {
            return Err(Refused);
        }
        let waiting = bench.bus().controller(self.node).tx_pending() + self.stuck;
        if waiting >= TX_FRAMES {
            self.flags |= flag::TX_FULL;
            return Err(Refused);
        }
        self.send(&frame, bench);
        Ok(vec![if frame.is_extended() { b'Z' } else { b'z' }])
    }

    fn send<D: Device>(&mut self, frame: &Frame, bench: &mut Bench<D>) {
        if bench.port(self.node).transmit(frame).is_err() {
            self.stuck += 1;
            self.flags |= flag::BUS_ERROR | flag::ERROR_PASSIVE | flag::ERROR_WARNING;
        }
    }

    /// Reading the flags clears them.
    fn read_flags<D: Device>(&mut self, bench: &mut Bench<D>) -> Result<Vec<u8>, Refused> {
        if self.channel == Channel::Closed {
            return Err(Refused);
        }
        let mut flags = std::mem::take(&mut self.flags);
        if bench.bus().controller(self.node).tec() > 0 {
            flags |= flag::BUS_ERROR;
        }
        Ok(format!("F{flags:02X}").into_bytes())
    }

    fn has_the_rate_of<D: Device>(&self, bench: &Bench<D>) -> bool {
        self.kbit_per_s == Some(bench.bus().bit_rate().kbit_per_s())
    }

    /// The bit rate of an open channel that is not that of the bus: such an adapter hears nothing.
    pub(crate) fn wrong_kbit_per_s<D: Device>(&self, bench: &Bench<D>) -> Option<u32> {
        let is_open = self.channel != Channel::Closed;
        self.kbit_per_s
            .filter(|_| is_open && !self.has_the_rate_of(bench))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drive_sim::{BitRate, ControllerConfig, DynDrive, DynDriveConfig};

    struct Rig {
        bench: Bench<DynDrive>,
        adapter: Adapter,
    }

    impl Rig {
        fn new() -> Self {
            let drive = DynDriveConfig::numbered(1).unwrap();
            let (mut bench, _) = Bench::with_drives(BitRate::Kbit1000, [drive]);
            let node = bench.add_master(ControllerConfig::device());
            let adapter = Adapter::new(&mut bench, node);
            bench.advance_to(200_000_000);
            Self { bench, adapter }
        }

        fn open() -> Self {
            let mut rig = Self::new();
            assert_eq!(rig.say("S8\rO\r"), "\r\r");
            rig
        }

        /// What comes back within 10 ms.
        fn say(&mut self, text: &str) -> String {
            self.adapter.hear(text.as_bytes(), &mut self.bench);
            let until_ns = self.bench.now_ns() + 10_000_000;
            self.bench.advance_to(until_ns);
            self.adapter.hand_on(&mut self.bench);
            String::from_utf8(std::mem::take(self.adapter.outbox())).unwrap()
        }
    }

    #[test]
    fn answers_a_closed_adapter_gives() {
        let mut rig = Rig::new();
        assert_eq!(rig.say("V\rN\r\r"), "V1013\rNVIRT\r\r");
        // No bit rate yet, nothing to close, nothing to send, no flags.
        assert_eq!(rig.say("O\rL\rC\rt03C188\rF\r"), "\x07\x07\x07\x07\x07");
        assert_eq!(
            rig.say("S9\rS\rS88\rZ2\rQ\rX1\r"),
            "\x07\x07\x07\x07\x07\x07"
        );
        for digit in 0..=8 {
            assert_eq!(rig.say(&format!("S{digit}\r")), "\r");
        }
        assert_eq!(rig.say("Z1\rZ0\r"), "\r\r");
    }

    #[test]
    fn answers_an_open_adapter_gives() {
        let mut rig = Rig::open();
        assert_eq!(rig.say("S8\rO\rL\rZ1\r"), "\x07\x07\x07\x07");
        assert_eq!(rig.say("F\r"), "F00\r");
        // Damaged, too long, and with a time stamp, which only received frames have.
        assert_eq!(rig.say("t03C\rt03C9\rt03C1880BB8\r"), "\x07\x07\x07");
        assert_eq!(
            rig.say("T000001000\rR000001000\rr1000\rt1000\r"),
            "Z\rZ\rz\rz\r"
        );
        assert_eq!(rig.say("C\rC\r"), "\r\x07");
    }

    #[test]
    fn a_drive_answers_through_it() {
        let mut rig = Rig::open();
        // Read_Drive_Status: on position, enabled, no alarm.
        assert_eq!(rig.say("t0290\r"), "z\rt029100\r");
        // General_Read of the position, after one step of -120.
        assert_eq!(rig.say("t03C188\r"), "z\r");
        rig.bench.advance_to(2_000_000_000);
        assert_eq!(rig.say("t02E11B\r"), "z\rt02E188\r");
    }

    #[test]
    fn received_frames_carry_a_time_stamp_on_request() {
        let mut rig = Rig::new();
        rig.say("Z1\rS8\rO\r");
        // 200 ms of power-on and three exchanges of 10 ms are over.
        assert_eq!(rig.say("t0290\r"), "z\rt02910000DC\r");
    }

    #[test]
    fn listening_only_sends_nothing() {
        let mut rig = Rig::new();
        assert_eq!(rig.say("S8\rL\rt0290\r"), "\r\r\x07");
    }

    #[test]
    fn another_bit_rate_hears_nothing_and_fills_up() {
        let mut rig = Rig::new();
        rig.say("S6\rO\r");
        assert_eq!(rig.adapter.wrong_kbit_per_s(&rig.bench), Some(500));
        assert_eq!(rig.say("t0290\r"), "z\r");
        assert_eq!(rig.say("F\r"), "FA4\r");
        let burst = "t0290\r".repeat(TX_FRAMES);
        assert_eq!(rig.say(&burst), "z\r".repeat(TX_FRAMES - 1) + "\x07");
        assert_eq!(rig.say("F\r"), "FA6\r");
    }

    #[test]
    fn a_burst_beyond_the_queue_is_refused_and_told() {
        let mut rig = Rig::open();
        let burst = "t03C101\r".repeat(TX_FRAMES + 2);
        assert_eq!(rig.say(&burst), "z\r".repeat(TX_FRAMES) + "\x07\x07");
        assert_eq!(rig.say("F\r"), "F02\r");
    }

    #[test]
    fn a_host_that_reads_nothing_loses_frames_and_can_see_it() {
        let mut rig = Rig::open();
        for _ in 0..RX_BYTES {
            rig.adapter.hear(b"t0290\r", &mut rig.bench);
            let until_ns = rig.bench.now_ns() + 1_000_000;
            rig.bench.advance_to(until_ns);
            rig.adapter.hand_on(&mut rig.bench);
        }
        rig.adapter.outbox().clear();
        assert_eq!(rig.say("F\r"), "F08\r");
    }
}
