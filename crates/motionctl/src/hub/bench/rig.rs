//! Hub motors, bus and adapter, moved along with the clock on the wall.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use drive_sim::{Bench, Bus, ControllerConfig, DeviceId, NodeId as BusNode, ZlacDrive};

use super::arguments::Arguments;
use super::report::Report;
use crate::bench::{Adapter, BenchError, SwitchOutput, power_cycles};
use crate::host_port::HostPort;
use crate::interrupt;
use crate::output::tell;
use crate::system::wait_for_input;

/// The longest wait, so that Ctrl-C is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// The wait for a host that reads too slowly.
const WAIT_FOR_ROOM: Duration = Duration::from_millis(1);
/// How long the power is off in a power cycle.
const POWER_OFF_NS: u64 = 100_000_000;
/// The drives were powered on so long before that they answer from the start.
const WARM_UP_NS: u64 = 200_000_000;
/// Over-current.
const ALARM: u16 = 0x0004;

/// A bench behind a pseudo-terminal or a port.
pub(super) struct Rig<'a> {
    arguments: &'a Arguments,
    bench: Bench<ZlacDrive>,
    node: BusNode,
    drives: Vec<DeviceId>,
    /// The user asks for a power cycle of every drive.
    is_power_cycled: Arc<AtomicBool>,
    adapter: Adapter,
    port: HostPort,
    switch: Option<SwitchOutput>,
    start: Instant,
    /// The bit rate that the user was warned of.
    warned_kbit_per_s: Option<u32>,
}

impl<'a> Rig<'a> {
    /// Drives that have started, behind a terminal.
    ///
    /// # Errors
    /// [`BenchError`] when the terminal or the signal handler cannot be made.
    pub(super) fn new(arguments: &'a Arguments) -> Result<Self, BenchError> {
        let mut bench = Bench::new(Bus::new(arguments.bit_rate));
        let node = bench.add_master(ControllerConfig::device());
        let drives: Vec<DeviceId> = arguments
            .nodes()
            .into_iter()
            .map(|node| {
                let drive = ZlacDrive::new(arguments.drive(node));
                bench.add_device(drive, ControllerConfig::device())
            })
            .collect();
        befall(arguments, &mut bench, &drives);
        bench.advance_to(WARM_UP_NS);
        let adapter = Adapter::new(&mut bench, node);
        let place = &arguments.slcan;
        let port = HostPort::create(place, "the adapter").map_err(|source| BenchError::Create {
            place: place.clone(),
            source,
        })?;
        Ok(Self {
            switch: arguments.mechanics.switch_output()?,
            arguments,
            bench,
            node,
            adapter,
            drives,
            is_power_cycled: power_cycles().map_err(BenchError::Interrupt)?,
            port,
            start: Instant::now(),
            warned_kbit_per_s: None,
        })
    }

    /// Number of drives.
    pub(super) fn drives(&self) -> usize {
        self.drives.len()
    }

    /// Where programs find the drives, for a message.
    pub(super) fn port(&self) -> &HostPort {
        &self.port
    }

    /// Runs until the user asks to stop.
    ///
    /// # Errors
    /// [`BenchError::Terminal`].
    pub(super) fn serve(&mut self) -> Result<(), BenchError> {
        while interrupt::requests() == 0 {
            self.step().map_err(BenchError::Terminal)?;
        }
        Ok(())
    }

    /// The bus up to now, bytes in, answers and frames out, wait.
    fn step(&mut self) -> io::Result<()> {
        while self.bench.step_to(self.now_ns()) {
            self.adapter.hand_on(&mut self.bench);
        }
        if self.is_power_cycled.swap(false, Ordering::Relaxed) {
            for &drive in &self.drives {
                let faults = self.bench.device_mut(drive).faults_mut();
                faults.power_cycle(POWER_OFF_NS);
            }
        }
        let now_ns = self.now_ns();
        if let (Some(switch), Some(&drive)) = (&mut self.switch, self.drives.first()) {
            switch.tell(self.bench.device(drive).switch_is_operated(now_ns))?;
        }
        let is_behind = self.serve_adapter()?;
        let wait = if is_behind {
            WAIT_FOR_ROOM
        } else {
            LONGEST_WAIT
        };
        let due_ns = self.bench.next_event_ns().unwrap_or(u64::MAX);
        let until_due = Duration::from_nanos(due_ns.saturating_sub(self.now_ns()));
        wait_for_input(&self.port.inputs(), wait.min(until_due))
    }

    /// Commands in, answers and frames out; tells whether something waits for a host that reads too slowly.
    fn serve_adapter(&mut self) -> io::Result<bool> {
        let mut buffer = [0; 4_096];
        let heard = self.port.read(&mut buffer)?;
        self.adapter.hear(heard, &mut self.bench);
        let outbox = self.adapter.outbox();
        let written = self.port.write(outbox)?;
        outbox.drain(..written);
        let is_behind = !outbox.is_empty();
        self.warn_of_bit_rate();
        Ok(is_behind)
    }

    fn now_ns(&self) -> u64 {
        let elapsed_ns = u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        elapsed_ns.saturating_add(WARM_UP_NS)
    }

    fn warn_of_bit_rate(&mut self) {
        let wrong = self.adapter.wrong_kbit_per_s(&self.bench);
        if let Some(kbit_per_s) = wrong.filter(|_| wrong != self.warned_kbit_per_s) {
            tell(format_args!(
                "note: the adapter was opened at {kbit_per_s} kbit/s, the bus runs at {} kbit/s: nothing gets through",
                self.arguments.bit_rate.kbit_per_s()
            ));
        }
        self.warned_kbit_per_s = wrong;
    }

    /// What each drive has received.
    pub(super) fn report(&self) -> Report {
        Report::new(&self.bench, self.node, self.adapter.refusals())
    }
}

/// Makes drives as they shall be.
fn befall(arguments: &Arguments, bench: &mut Bench<ZlacDrive>, drives: &[DeviceId]) {
    let alarmed = arguments.alarm.as_ref();
    let alarmed = alarmed.map_or(Vec::new(), |nodes| nodes.or_factory());
    for (&drive, node) in drives.iter().zip(arguments.nodes()) {
        let faults = bench.device_mut(drive).faults_mut();
        if alarmed.contains(&node) {
            faults.trip(ALARM);
            faults.remove_cause();
        }
        if let Some(writes) = arguments.silent_after_writes {
            faults.fall_silent_after_writes(writes);
        }
    }
}
