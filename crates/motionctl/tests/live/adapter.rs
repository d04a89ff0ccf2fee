//! A CAN adapter with simulated drives behind it, which behaves as one of the adapters that people have.
//!
//! It shares nothing with the tool: it reads the text of the Lawicel protocol by itself, and the drives count what reaches them.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, Frame, NodeId,
};
use dyn_can::Alarm;
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id, StandardId};

use crate::bench::{scratch, wait_until};
use crate::terminal::Terminal;

/// Frames that wait in the adapter; one more is refused.
const QUEUE: usize = 32;
/// Letters of a command that the adapter has room for; more are forgotten.
const ROOM: usize = 64;
/// Identifiers of the set-points of drives 1 and 2.
const SET_POINTS: [StandardId; 2] = match (StandardId::new(0x03C), StandardId::new(0x05C)) {
    (Some(one), Some(two)) => [one, two],
    _ => panic!("identifiers"),
};
/// After so long the tool has read what was left in the line from before.
const SETTLED: Duration = Duration::from_secs(1);
/// Longer than a drive takes to start.
const POWERED_NS: u64 = 1_000_000_000;

/// What is odd about an adapter. Each is a kind of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Manner {
    /// The answer to `V`; `None`: it refuses it.
    pub(crate) version: Option<&'static str>,
    /// It does not even refuse a command that it does not know.
    pub(crate) ignores_unknown: bool,
    /// It answers commands.
    pub(crate) acknowledges: bool,
    /// It answers nothing but frames and, where there is one, its version.
    pub(crate) knows_listen: bool,
    /// It hears nothing for so long after it was opened.
    pub(crate) boots: Duration,
    /// Of what comes in at a time it reads the first command only.
    pub(crate) one_command_a_packet: bool,
    /// An empty line is its last command once more.
    pub(crate) repeats: bool,
    /// Every so many answers one is lost.
    pub(crate) loses_every: Option<usize>,
    /// Every so many answers one comes twice.
    pub(crate) doubles_every: Option<usize>,
    /// Every so many answers a BEL comes that belongs to nothing.
    pub(crate) bell_every: Option<usize>,
    /// Every so many frames one is refused.
    pub(crate) refuses_every: Option<usize>,
    /// Digits of the time stamps of received frames.
    pub(crate) stamp_digits: usize,
    /// It writes so many bytes at a time, with a pause in between.
    pub(crate) portions: Option<usize>,
    /// What an earlier user told it last, its channel still open.
    pub(crate) left_open_after: Option<&'static str>,
    /// The begin of a command that an earlier user did not finish.
    pub(crate) half_a_command: &'static str,
}

impl Manner {
    /// As the manual of the CAN232 says.
    pub(crate) const LAWICEL: Self = Self {
        version: Some("V1013"),
        ignores_unknown: false,
        acknowledges: true,
        knows_listen: true,
        boots: Duration::ZERO,
        one_command_a_packet: false,
        repeats: false,
        loses_every: None,
        doubles_every: None,
        bell_every: None,
        refuses_every: None,
        stamp_digits: 0,
        portions: None,
        left_open_after: None,
        half_a_command: "",
    };
}

/// One drive at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DriveEnd {
    pub(crate) enabled: bool,
    /// Sum of the steps that it has taken.
    pub(crate) counts: i64,
    /// Set-points that it has taken, and that came while it was off.
    pub(crate) set_points: u64,
    pub(crate) ignored: u64,
}

/// What became of everything.
#[derive(Debug)]
pub(crate) struct End {
    pub(crate) drives: [DriveEnd; 2],
    /// Frames that were sent because an empty line repeats a command.
    pub(crate) repeated: usize,
    /// Frames that were sent before the channel was opened anew.
    pub(crate) early: usize,
    /// Answers that were lost, doubled or invented.
    pub(crate) spoilt: usize,
    /// Set-points of each drive that were refused.
    pub(crate) refused: [u64; 2],
}

/// How far the tool has come, as its frames tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Stage {
    /// It opened the channel, to send or to listen, a second ago.
    Listens,
    /// It has asked something.
    Looks,
    /// It has told drive 1 to switch on.
    Enables,
    /// It has sent thirty set-points to drive 1.
    Streams,
    /// It has told drive 1 to switch off.
    Disables,
}

/// What the tool has sent so far.
#[derive(Debug, Default)]
struct Progress {
    opened: OnceLock<Instant>,
    frames: AtomicU32,
    enables: AtomicU32,
    set_points: AtomicU32,
    disables: AtomicU32,
}

impl Progress {
    fn note(&self, frame: &Frame) {
        let is = |id: u16| StandardId::new(id).is_some_and(|id| frame.id() == Id::Standard(id));
        self.frames.fetch_add(1, Ordering::Relaxed);
        // Functions 1Ch and 19h of drive 1: a set-point, and Servo_Disable with 00 for on and FF for off.
        if is(0x03C) {
            self.set_points.fetch_add(1, Ordering::Relaxed);
        } else if is(0x039) && frame.data() == [0x00] {
            self.enables.fetch_add(1, Ordering::Relaxed);
        } else if is(0x039) {
            self.disables.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn has_reached(&self, stage: Stage) -> bool {
        let (count, least) = match stage {
            Stage::Listens => {
                let opened = self.opened.get();
                return opened.is_some_and(|opened| opened.elapsed() >= SETTLED);
            }
            Stage::Looks => (&self.frames, 1),
            Stage::Enables => (&self.enables, 1),
            Stage::Streams => (&self.set_points, 30),
            Stage::Disables => (&self.disables, 1),
        };
        count.load(Ordering::Relaxed) >= least
    }
}

/// What goes wrong at a stage, by itself: nobody who waits for the stage can be too late.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mishap {
    /// It is pulled out.
    Vanishes,
    /// It does nothing any more.
    Freezes,
    /// The drive at this place raises an alarm.
    Alarm(usize),
}

/// An adapter that is running, with drive 1 off and drive 2 on.
pub(crate) struct FakeAdapter {
    link: PathBuf,
    is_over: Arc<AtomicBool>,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<End>>,
}

impl FakeAdapter {
    pub(crate) fn start(name: &str, manner: Manner) -> Self {
        Self::start_until(name, manner, None)
    }

    /// One to which something happens with the frame that begins a stage.
    pub(crate) fn start_until(name: &str, manner: Manner, mishap: Option<(Stage, Mishap)>) -> Self {
        Self::start_at(scratch(&format!("adapter-{name}")), manner, mishap)
    }

    /// The same with its terminal at a path.
    pub(crate) fn start_at(
        link: PathBuf,
        manner: Manner,
        mut mishap: Option<(Stage, Mishap)>,
    ) -> Self {
        let mut terminal = Terminal::new(&link);
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let progress = Arc::new(Progress::default());
        let (seen, place) = (Arc::clone(&progress), link.clone());
        let thread = std::thread::spawn(move || {
            let mut device = Device::new(manner, seen);
            while !over.load(Ordering::Relaxed) {
                let heard = terminal.read();
                device.hear(&heard);
                let is_time =
                    |(stage, _): &mut (Stage, Mishap)| device.progress.has_reached(*stage);
                match mishap.take_if(is_time) {
                    Some((_, Mishap::Vanishes)) => {
                        // Nobody shall find another terminal there.
                        let _ = std::fs::remove_file(&place);
                        break;
                    }
                    Some((_, Mishap::Freezes)) => {
                        wait_until("it is taken away", || over.load(Ordering::Relaxed));
                        break;
                    }
                    Some((_, Mishap::Alarm(place))) => device.raise_alarm(place),
                    None => {}
                }
                device.pass_on();
                terminal.write(&mut device.to_host, manner.portions);
            }
            device.end()
        });
        Self {
            link,
            is_over,
            progress,
            thread: Some(thread),
        }
    }

    /// Waits until the tool has come so far.
    pub(crate) fn await_stage(&self, stage: Stage) {
        self.await_stage_or(stage, || false);
    }

    /// Waits until the tool has come so far, or has ended.
    pub(crate) fn await_stage_or(&self, stage: Stage, mut is_over: impl FnMut() -> bool) {
        wait_until(&format!("{stage:?}"), || {
            self.progress.has_reached(stage) || is_over()
        });
    }

    pub(crate) fn has_reached(&self, stage: Stage) -> bool {
        self.progress.has_reached(stage)
    }

    pub(crate) fn path(&self) -> &str {
        self.link.to_str().expect("a path of plain text")
    }

    /// Takes it away as a pulled plug does, and reads its drives.
    pub(crate) fn stop(mut self) -> End {
        self.is_over.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("it runs");
        thread.join().expect("no panic")
    }
}

impl Drop for FakeAdapter {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The test fails for its own reason already.
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.link);
    }
}

/// The adapter itself.
struct Device {
    manner: Manner,
    bench: Bench<DynDrive>,
    node: NodeId,
    drives: [DeviceId; 2],
    start: Instant,
    /// When the first byte came.
    opened: Option<Instant>,
    is_open: bool,
    /// The channel was opened by the present user.
    is_set_up: bool,
    line: Vec<u8>,
    last: Vec<u8>,
    to_host: Vec<u8>,
    answers: usize,
    frames: usize,
    progress: Arc<Progress>,
    end: End,
}

impl Device {
    fn new(manner: Manner, progress: Arc<Progress>) -> Self {
        let mut bench = Bench::new(Bus::new(BitRate::Kbit1000));
        let node = bench.add_master(ControllerConfig::device());
        let drives = [(1, false), (2, true)].map(|(number, is_on)| {
            let config = DynDriveConfig {
                enabled_after_power_on: is_on,
                ..DynDriveConfig::numbered(number).expect("an id")
            };
            bench.add_device(DynDrive::new(config), ControllerConfig::device())
        });
        bench.advance_to(POWERED_NS);
        let nothing = DriveEnd {
            enabled: false,
            counts: 0,
            set_points: 0,
            ignored: 0,
        };
        Self {
            manner,
            bench,
            node,
            drives,
            start: Instant::now(),
            opened: None,
            is_open: manner.left_open_after.is_some(),
            is_set_up: false,
            line: manner.half_a_command.as_bytes().to_vec(),
            last: manner.left_open_after.unwrap_or("").as_bytes().to_vec(),
            to_host: Vec::new(),
            answers: 0,
            frames: 0,
            progress,
            end: End {
                drives: [nothing; 2],
                repeated: 0,
                early: 0,
                spoilt: 0,
                refused: [0; 2],
            },
        }
    }

    fn raise_alarm(&mut self, place: usize) {
        let drive = self.bench.device_mut(self.drives[place]);
        drive.faults_mut().raise_alarm(Alarm::OverCurrent);
    }

    fn hear(&mut self, bytes: &[u8]) {
        let now_ns = u64::try_from(self.start.elapsed().as_nanos()).expect("a short test");
        self.bench.advance_to(POWERED_NS + now_ns);
        if bytes.is_empty() {
            return;
        }
        let opened = *self.opened.get_or_insert_with(Instant::now);
        if opened.elapsed() < self.manner.boots {
            return;
        }
        let mut commands = 0;
        for &byte in bytes {
            if byte != b'\r' {
                if self.line.len() >= ROOM {
                    self.line.clear();
                }
                self.line.push(byte);
                continue;
            }
            let command = std::mem::take(&mut self.line);
            commands += 1;
            if !self.manner.one_command_a_packet || commands == 1 {
                self.obey(command);
            }
        }
    }

    fn obey(&mut self, mut command: Vec<u8>) {
        let is_repeated = command.is_empty() && self.manner.repeats;
        if is_repeated {
            command.clone_from(&self.last);
        }
        self.last.clone_from(&command);
        let done = match command.as_slice() {
            [b'V'] if self.manner.version.is_some() || !self.manner.ignores_unknown => {
                let version = self.manner.version.unwrap_or("\x07");
                self.to_host.extend(version.bytes());
                if self.manner.version.is_some() {
                    self.to_host.push(b'\r');
                }
                return;
            }
            [b'C'] => std::mem::take(&mut self.is_open),
            [b'S', b'8'] => !self.is_open,
            [b'O'] => {
                self.is_set_up = true;
                !std::mem::replace(&mut self.is_open, true)
            }
            [b'L'] => self.manner.knows_listen && !std::mem::replace(&mut self.is_open, true),
            [b't', ..] => return self.transmit(&command, is_repeated),
            _ if self.manner.ignores_unknown => return,
            _ => false,
        };
        if done && matches!(command.as_slice(), [b'O' | b'L']) {
            self.progress.opened.get_or_init(Instant::now);
        }
        if self.manner.acknowledges {
            self.to_host.push(if done { b'\r' } else { 0x07 });
        }
    }

    fn transmit(&mut self, command: &[u8], is_repeated: bool) {
        let Some(frame) = frame_of(command).filter(|_| self.is_open) else {
            return self.answer(b"\x07");
        };
        self.frames += 1;
        let is_refused = every(self.manner.refuses_every, self.frames)
            || self.bench.bus().controller(self.node).tx_pending() >= QUEUE;
        if is_refused {
            for (refused, id) in self.end.refused.iter_mut().zip(SET_POINTS) {
                *refused += u64::from(frame.id() == Id::Standard(id));
            }
            return self.answer(b"\x07");
        }
        self.end.repeated += usize::from(is_repeated);
        self.end.early += usize::from(!self.is_set_up);
        self.progress.note(&frame);
        self.bench.port(self.node).transmit(&frame).expect("room");
        self.answer(b"z\r");
    }

    /// An answer to a frame, spoilt now and then.
    fn answer(&mut self, text: &[u8]) {
        if !self.manner.acknowledges {
            return;
        }
        self.answers += 1;
        let [lost, doubled, bell] = [
            self.manner.loses_every,
            self.manner.doubles_every,
            self.manner.bell_every,
        ]
        .map(|period| every(period, self.answers));
        self.end.spoilt += usize::from(lost || doubled || bell);
        if bell {
            self.to_host.push(0x07);
        }
        for _ in 0..1 + usize::from(doubled) - usize::from(lost) {
            self.to_host.extend(text);
        }
    }

    /// Received frames go to the host.
    fn pass_on(&mut self) {
        while let Ok(frame) = self.bench.port(self.node).receive() {
            let Id::Standard(id) = frame.id() else {
                panic!("drives send standard frames")
            };
            if !self.is_open {
                continue;
            }
            let mut line = format!("t{:03X}{}", id.as_raw(), frame.data().len());
            for byte in frame.data() {
                line += &format!("{byte:02X}");
            }
            let ms = self.bench.now_ns() / 1_000_000;
            match self.manner.stamp_digits {
                4 => line += &format!("{:04X}", ms % 60_000),
                8 => line += &format!("{ms:08X}"),
                _ => {}
            }
            self.to_host.extend(line.bytes());
            self.to_host.push(b'\r');
        }
    }

    fn end(mut self) -> End {
        // What is on the bus arrives.
        self.bench.advance_to(self.bench.now_ns() + 500_000_000);
        self.end.drives = self.drives.map(|id| {
            let drive = self.bench.device(id);
            DriveEnd {
                enabled: drive.is_enabled(),
                counts: drive.commanded_counts(),
                set_points: drive.books().pd_frames,
                ignored: drive.books().pd_frames_ignored,
            }
        });
        self.end
    }
}

fn every(period: Option<usize>, number: usize) -> bool {
    period.is_some_and(|period| number.is_multiple_of(period))
}

/// `t`, three digits of identifier, one of length, two for each byte, and nothing else.
fn frame_of(command: &[u8]) -> Option<Frame> {
    let text = std::str::from_utf8(command).ok()?;
    if !text
        .get(1..)?
        .bytes()
        .all(|digit| digit.is_ascii_hexdigit())
    {
        return None;
    }
    let id = u16::from_str_radix(text.get(1..4)?, 16).ok()?;
    let length: usize = text.get(4..5)?.parse().ok()?;
    let digits = text.get(5..)?;
    if digits.len() != 2 * length {
        return None;
    }
    let bytes: Option<Vec<u8>> = (0..length)
        .map(|byte| u8::from_str_radix(digits.get(2 * byte..2 * byte + 2)?, 16).ok())
        .collect();
    Frame::new(StandardId::new(id)?, &bytes?)
}
