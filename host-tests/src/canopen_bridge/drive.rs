//! A simulated drive behind lines, in real time.
//!
//! | Command | Meaning |
//! |---|---|
//! | `trip BITS` | a fault with these bits of 603Fh |
//! | `cure` | the cause of the fault is gone |
//! | `power-cycle` | off and on again |
//! | `offline` | the master's frames and the drive's are lost until `online` |
//! | `wear` | `!wear SINGLE SAVES` |
//! | `wheel` | `!wheel COUNTS RPM` |

use std::io::{self, BufRead, Write};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use drive_sim::{
    Bench, BitRate, ControllerConfig, DeviceId, NodeId as BusNode, ZlacDrive, ZlacDriveConfig,
};
use embedded_can::nb::Can;
use zlac8030l::NodeId;

use super::{frame, hex};

/// How often the simulated bus catches up with the clock.
const STEP: Duration = Duration::from_millis(1);

/// Serves lines until standard input ends.
///
/// # Errors
/// When standard output is closed.
pub fn run(node: NodeId) -> io::Result<()> {
    let (mut bench, drives) =
        Bench::with_zlac_drives(BitRate::Kbit500, [ZlacDriveConfig::new(node)]);
    let master = bench.add_master(ControllerConfig::device());
    let [drive] = drives[..] else {
        return Err(io::Error::other("one drive was asked for"));
    };
    let mut bridge = Bridge {
        bench,
        drive,
        master,
        started: Instant::now(),
        out: io::stdout(),
    };
    let lines = lines();
    loop {
        match lines.recv_timeout(STEP) {
            Ok(line) => bridge.take(&line)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        bridge.catch_up()?;
    }
}

/// The lines of standard input, read by a thread of their own: reading blocks.
fn lines() -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    receiver
}

struct Bridge<W> {
    bench: Bench<ZlacDrive>,
    drive: DeviceId,
    master: BusNode,
    started: Instant,
    out: W,
}

impl<W: Write> Bridge<W> {
    fn take(&mut self, line: &str) -> io::Result<()> {
        let Some(frame) = frame(line) else {
            self.obey(line)?;
            return writeln!(self.out, "!done");
        };
        if let Some(frame) = frame.to_can() {
            // The queue of this controller is as long as the master likes.
            let accepted = self.bench.port(self.master).transmit(&frame).is_ok();
            debug_assert!(accepted);
        }
        Ok(())
    }

    fn obey(&mut self, line: &str) -> io::Result<()> {
        let now_ns = self.bench.now_ns();
        let drive = self.bench.device_mut(self.drive);
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["trip", bits] => match hex(bits) {
                Some(bits) => drive.faults_mut().trip(bits),
                None => writeln!(self.out, "!error")?,
            },
            ["cure"] => drive.faults_mut().remove_cause(),
            ["power-cycle"] => drive.faults_mut().power_cycle(0),
            ["offline"] => drive.faults_mut().leave_bus(),
            ["online"] => drive.faults_mut().wake(),
            ["wear"] => {
                let wear = drive.eeprom_wear();
                writeln!(self.out, "!wear {} {}", wear.single_writes, wear.saves)?;
            }
            ["wheel"] => writeln!(
                self.out,
                "!wheel {} {:.3}",
                drive.travel_counts(now_ns),
                drive.speed_rpm(now_ns)
            )?,
            _ => writeln!(self.out, "!error")?,
        }
        Ok(())
    }

    fn catch_up(&mut self) -> io::Result<()> {
        let now_ns = self.started.elapsed().as_nanos() as u64;
        loop {
            let more = self.bench.advance_until_received(self.master, now_ns);
            while let Ok(frame) = self.bench.port(self.master).receive() {
                writeln!(self.out, "{frame}")?;
            }
            if !more {
                return self.out.flush();
            }
        }
    }
}
