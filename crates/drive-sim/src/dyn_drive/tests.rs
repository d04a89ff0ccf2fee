//! Tests of whole drives: literal frames in, literal frames and books out.

mod books;
mod commands;
mod faults;
mod gains;
mod mechanics;
mod power;
mod reads;
mod serial;

use dyn_can::{ConfigByte, Revision};

use super::*;
use crate::frame::tests::standard;

const MS: u64 = 1_000_000;

/// Response delay of [`DynDriveConfig::new`].
const DELAY_NS: u64 = 100_000;

/// A drive without a bus: frames arrive and leave in no time.
struct Probe {
    drive: DynDrive,
    now_ns: u64,
    sent: Vec<(u64, String)>,
}

impl Probe {
    /// A drive that is ready at 0 ns.
    fn new(config: DynDriveConfig) -> Self {
        Self {
            drive: DynDrive::new(DynDriveConfig {
                power_on_delay_ns: 0,
                ..config
            }),
            now_ns: 0,
            sent: Vec::new(),
        }
    }

    /// Drive 1 of revision 1.6A.
    fn v1_6a() -> Self {
        Self::new(drive_1())
    }

    /// Drive 1 of revision 1.2A.
    fn v1_2a() -> Self {
        Self::new(drive_1().with_revision(Revision::V1_2A))
    }

    /// A frame ends at the present instant.
    fn hear(&mut self, id: u16, data: &[u8]) {
        self.drive.on_frame(self.now_ns, &standard(id, data));
    }

    /// Runs the drive whenever it is due.
    fn wait(&mut self, duration_ns: u64) {
        let until_ns = self.now_ns + duration_ns;
        let mut not_before_ns = self.now_ns;
        while let Some(due_ns) = self.drive.next_event_ns()
            && due_ns.max(not_before_ns) <= until_ns
        {
            self.now_ns = due_ns.max(not_before_ns);
            let (now_ns, sent) = (self.now_ns, &mut self.sent);
            self.drive
                .run(now_ns, &mut |frame| sent.push((now_ns, frame.to_string())));
            not_before_ns = self.now_ns + 1;
        }
        self.now_ns = until_ns;
    }

    /// What was sent since the last call.
    fn take_sent(&mut self) -> Vec<String> {
        self.sent.drain(..).map(|(_, text)| text).collect()
    }

    /// What the drive sends within 10 ms of a frame.
    fn ask(&mut self, id: u16, data: &[u8]) -> Vec<String> {
        self.hear(id, data);
        self.wait(10 * MS);
        self.take_sent()
    }

    /// `frames` set-points of `data`, one each millisecond.
    fn stream(&mut self, data: &[u8], frames: u32) {
        for _ in 0..frames {
            self.hear(0x03C, data);
            self.wait(MS);
        }
    }

    fn position(&self) -> i64 {
        self.drive.position_counts(self.now_ns)
    }

    fn status(&self) -> u8 {
        self.drive.status(self.now_ns).to_byte()
    }
}

fn drive_1() -> DynDriveConfig {
    DynDriveConfig::numbered(1).unwrap()
}
