//! Drives, bus and adapter, moved along with the clock on the wall.

use std::path::Path;
use std::time::{Duration, Instant};

use drive_sim::{Bench, Bus, ControllerConfig, DynDrive, NodeId};

use super::adapter::Adapter;
use super::arguments::Arguments;
use super::error::BenchError;
use super::report::Report;
use crate::interrupt;
use crate::pty::Pty;

/// The longest wait, so that Ctrl-C is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// The wait for a host that reads too slowly.
const WAIT_FOR_ROOM: Duration = Duration::from_millis(1);

/// A bench behind a pseudo-terminal.
pub(super) struct Rig<'a> {
    arguments: &'a Arguments,
    bench: Bench<DynDrive>,
    node: NodeId,
    adapter: Adapter,
    pty: Pty,
    start: Instant,
    /// The bit rate that the user was warned of.
    warned_kbit_per_s: Option<u32>,
}

impl<'a> Rig<'a> {
    pub(super) fn new(arguments: &'a Arguments) -> Result<Self, BenchError> {
        let mut bench = Bench::new(Bus::new(arguments.bit_rate));
        let node = bench.add_master(ControllerConfig::device());
        for &drive in &arguments.drives {
            bench.add_device(
                arguments.drive_options.drive(drive),
                ControllerConfig::device(),
            );
        }
        let adapter = Adapter::new(&mut bench, node);
        let pty = Pty::create(&arguments.slcan).map_err(|source| BenchError::Create {
            link: arguments.slcan.clone(),
            source,
        })?;
        Ok(Self {
            arguments,
            bench,
            node,
            adapter,
            pty,
            start: Instant::now(),
            warned_kbit_per_s: None,
        })
    }

    /// The terminal behind the link.
    pub(super) fn terminal(&self) -> &Path {
        self.pty.line_path()
    }

    /// Runs until the user asks to stop.
    pub(super) fn serve(&mut self) -> Result<(), BenchError> {
        while interrupt::requests() == 0 {
            self.step().map_err(|source| BenchError::Terminal {
                link: self.arguments.slcan.clone(),
                source,
            })?;
        }
        Ok(())
    }

    /// The bus up to now, commands in, answers and frames out, wait.
    fn step(&mut self) -> std::io::Result<()> {
        let now_ns = self.now_ns();
        while self.bench.step_to(now_ns) {
            self.adapter.hand_on(&mut self.bench);
        }
        let mut buffer = [0; 4_096];
        let heard = self.pty.read(&mut buffer)?;
        self.adapter.hear(heard, &mut self.bench);
        self.warn_of_bit_rate();
        let outbox = self.adapter.outbox();
        let written = self.pty.write(outbox)?;
        outbox.drain(..written);
        let wait = if outbox.is_empty() {
            LONGEST_WAIT
        } else {
            WAIT_FOR_ROOM
        };
        let due_ns = self.bench.next_event_ns().unwrap_or(u64::MAX);
        let until_due = Duration::from_nanos(due_ns.saturating_sub(self.now_ns()));
        self.pty.wait(wait.min(until_due))
    }

    fn now_ns(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn warn_of_bit_rate(&mut self) {
        let wrong = self.adapter.wrong_kbit_per_s(&self.bench);
        if let Some(kbit_per_s) = wrong.filter(|_| wrong != self.warned_kbit_per_s) {
            eprintln!(
                "note: the adapter was opened at {kbit_per_s} kbit/s, the bus runs at {} kbit/s: nothing gets through",
                self.arguments.bit_rate.kbit_per_s()
            );
        }
        self.warned_kbit_per_s = wrong;
    }

    /// What each drive has received.
    pub(super) fn report(&self) -> Report {
        Report::new(&self.bench, self.node)
    }
}
