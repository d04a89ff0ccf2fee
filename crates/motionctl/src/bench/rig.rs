//! Drives, bus and adapter, moved along with the clock on the wall.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use drive_sim::dyn_drive::POWER_ON_DELAY_NS;
use drive_sim::{Bench, Bus, ControllerConfig, DeviceId, DynDrive, NodeId};
use dyn_can::Alarm;

use super::adapter::Adapter;
use super::arguments::{Arguments, Troubles};
use super::board::{Queue, Running, Seat};
use super::candump::BenchLog;
use super::error::BenchError;
use super::mechanics::SwitchOutput;
use super::report::Report;
use super::serial::Serial;
use crate::host_port::{HostPort, Place};
use crate::interrupt;
use crate::output::tell;
use crate::system::{self, Input, wait_for_input};

/// The longest wait, so that Ctrl-C is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// The wait for a host that reads too slowly.
const WAIT_FOR_ROOM: Duration = Duration::from_millis(1);

/// How long the power is off in a power cycle.
const POWER_OFF_NS: u64 = 100_000_000;

/// A bench behind pseudo-terminals or ports.
pub(super) struct Rig<'a> {
    arguments: &'a Arguments,
    bench: Bench<DynDrive>,
    node: NodeId,
    drives: Vec<DeviceId>,
    /// The user asks for a power cycle of every drive.
    is_power_cycled: Arc<AtomicBool>,
    /// Closed for ever where it has no port.
    adapter: Adapter,
    adapter_port: Option<HostPort>,
    serial: Option<Serial>,
    switch: Option<SwitchOutput>,
    /// A motion board on the bus, apart from what runs on it.
    board: Option<Seat>,
    log: Option<BenchLog>,
    start: Instant,
    /// The bit rate that the user was warned of.
    warned_kbit_per_s: Option<u32>,
}

impl<'a> Rig<'a> {
    pub(super) fn new(arguments: &'a Arguments) -> Result<Self, BenchError> {
        let mut bench = Bench::new(Bus::new(arguments.bit_rate));
        let node = bench.add_master(ControllerConfig::device());
        let options = &arguments.drive_options;
        let ids = arguments.ids();
        let numbered = ids.iter().map(|&drive| options.config(drive));
        let twins = arguments.troubles.twin.iter().flatten();
        let fresh = (0..arguments.fresh).map(|number| options.fresh_config(number));
        let drives: Vec<DeviceId> = numbered
            .chain(twins.map(|&drive| options.twin_config(drive)))
            .chain(fresh)
            .map(|config| DynDrive::new(arguments.mechanics.on(config)))
            .map(|drive| bench.add_device(drive, ControllerConfig::device()))
            .collect();
        // A drive that starts has no alarm yet.
        bench.advance_to(POWER_ON_DELAY_NS);
        arguments.troubles.befall(&mut bench, &drives);
        let adapter = Adapter::new(&mut bench, node);
        let board = Seat::new(&arguments.board, &mut bench)?;
        let log = BenchLog::open(arguments.candump.as_deref(), &mut bench, board.as_ref())?;
        let terminals = &arguments.terminals;
        Ok(Self {
            arguments,
            bench,
            node,
            adapter,
            drives: drives.clone(),
            is_power_cycled: power_cycles().map_err(BenchError::Interrupt)?,
            adapter_port: create(terminals.slcan.as_ref(), |place| {
                HostPort::create(place, "the adapter")
            })?,
            serial: create(terminals.serial.as_ref(), |place| {
                Serial::create(place, &drives)
            })?,
            switch: arguments.mechanics.switch_output()?,
            board,
            log,
            start: Instant::now(),
            warned_kbit_per_s: None,
        })
    }

    /// Number of drives.
    pub(super) fn drives(&self) -> usize {
        self.bench.devices().len()
    }

    /// Where programs find the drives, for a message.
    pub(super) fn places(&self) -> String {
        let names: Vec<String> = self.ports().map(ToString::to_string).collect();
        names.join(" and ")
    }

    fn ports(&self) -> impl Iterator<Item = &HostPort> {
        let serial = self.serial.as_ref().map(Serial::port);
        let board = self.board.as_ref().map(Seat::port);
        self.adapter_port.iter().chain(serial).chain(board)
    }

    /// Runs until the user asks to stop.
    pub(super) fn serve(&mut self) -> Result<(), BenchError> {
        while interrupt::requests() == 0 {
            // From one start of the board to the next, where there is one.
            let mut queue = Queue::new();
            let seat = self.board.as_mut();
            let mut running = seat.map(|seat| seat.start(&mut queue, &mut self.bench));
            while interrupt::requests() == 0 && !self.is_reset(running.as_ref()) {
                self.step(running.as_mut()).map_err(BenchError::Terminal)?;
            }
            if let (Some(seat), Some(running)) = (&mut self.board, running) {
                seat.end(running);
            }
        }
        Ok(())
    }

    fn is_reset(&mut self, running: Option<&Running<'_>>) -> bool {
        let both = self.board.as_mut().zip(running);
        both.is_some_and(|(seat, running)| running.is_reset(seat))
    }

    /// Bus and line up to now, bytes in, answers and frames out, wait.
    fn step(&mut self, mut board: Option<&mut Running<'_>>) -> io::Result<()> {
        self.run_to(self.now_ns(), board.as_deref_mut())?;
        if self.is_power_cycled.swap(false, Ordering::Relaxed) {
            for &drive in &self.drives {
                let faults = self.bench.device_mut(drive).faults_mut();
                faults.power_cycle(POWER_OFF_NS);
            }
            if let Some(seat) = &mut self.board {
                seat.power_off_until(self.bench.now_ns() + POWER_OFF_NS);
            }
        }
        let mut is_behind = self.serve_adapter()?;
        if let (Some(board), Some(seat)) = (board.as_deref_mut(), &mut self.board) {
            is_behind |= board.exchange(seat)?;
        }
        if let Some(serial) = &mut self.serial {
            serial.exchange(&mut self.bench)?;
        }
        if let (Some(switch), Some(&drive)) = (&mut self.switch, self.drives.first()) {
            let now_ns = self.bench.now_ns();
            switch.tell(self.bench.device(drive).switch_is_operated(now_ns))?;
        }
        let wait = if is_behind {
            WAIT_FOR_ROOM
        } else {
            LONGEST_WAIT
        };
        let serial = self.serial.as_ref();
        let due_ns = self.bench.next_event_ns().into_iter();
        let due_ns = due_ns
            .chain(serial.and_then(|serial| serial.next_event_ns(&self.bench)))
            .chain(board.map(|board| board.next_cycle_ns()))
            .min()
            .unwrap_or(u64::MAX);
        let until_due = Duration::from_nanos(due_ns.saturating_sub(self.now_ns()));
        let inputs: Vec<Input<'_>> = self.ports().flat_map(HostPort::inputs).collect();
        wait_for_input(&inputs, wait.min(until_due))
    }

    /// Lets time pass until `now_ns`; bytes reach the drives, and cycles of the board begin, at their own instants.
    fn run_to(&mut self, now_ns: u64, mut board: Option<&mut Running<'_>>) -> io::Result<()> {
        loop {
            let arrival_ns = self.serial.as_ref().and_then(Serial::next_arrival_ns);
            let cycle_ns = board.as_ref().map(|board| board.next_cycle_ns());
            let next_ns = arrival_ns.into_iter().chain(cycle_ns).min();
            let next_ns = next_ns.filter(|at_ns| *at_ns <= now_ns);
            self.pass_time_to(next_ns.unwrap_or(now_ns), board.as_deref_mut());
            if let Some(log) = &mut self.log {
                log.drain(&mut self.bench);
            }
            if next_ns.is_none() {
                return Ok(());
            }
            if let (Some(serial), true) = (&mut self.serial, arrival_ns == next_ns) {
                serial.deliver(&mut self.bench);
            }
            if let (Some(board), Some(seat), true) =
                (board.as_deref_mut(), &mut self.board, cycle_ns == next_ns)
            {
                board.begin_cycle(seat, &self.bench)?;
            }
        }
    }

    fn pass_time_to(&mut self, until_ns: u64, mut board: Option<&mut Running<'_>>) {
        loop {
            if let (Some(board), Some(seat)) = (board.as_deref_mut(), &self.board) {
                board.serve(seat, &mut self.bench);
            }
            if !self.bench.step_to(until_ns) {
                return;
            }
            self.adapter.hand_on(&mut self.bench);
        }
    }

    /// Commands in, answers and frames out; tells whether something waits for a host that reads too slowly.
    fn serve_adapter(&mut self) -> io::Result<bool> {
        let Some(port) = &mut self.adapter_port else {
            return Ok(false);
        };
        let mut buffer = [0; 4_096];
        let heard = port.read(&mut buffer)?;
        self.adapter.hear(heard, &mut self.bench);
        let outbox = self.adapter.outbox();
        let written = port.write(outbox)?;
        outbox.drain(..written);
        let is_behind = !outbox.is_empty();
        self.warn_of_bit_rate();
        Ok(is_behind)
    }

    /// The drives were powered on so long before that they answer from the start.
    fn now_ns(&self) -> u64 {
        let elapsed_ns = u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        elapsed_ns.saturating_add(POWER_ON_DELAY_NS)
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
    ///
    /// # Errors
    /// When the log could not be written to its end.
    pub(super) fn report(self) -> Result<Report, BenchError> {
        if let Some(log) = self.log {
            log.finish()?;
        }
        let board = self.board.as_ref().map(Seat::report);
        let refusals = self.adapter.refusals();
        Ok(Report::new(&self.bench, self.node, refusals, board))
    }
}

/// From now on the user can ask for a power cycle, where the system has a way.
pub(crate) fn power_cycles() -> io::Result<Arc<AtomicBool>> {
    let is_asked = Arc::new(AtomicBool::new(false));
    system::note_power_cycles(&is_asked)?;
    Ok(is_asked)
}

impl Troubles {
    /// Makes drives that have started as they shall be.
    fn befall(&self, bench: &mut Bench<DynDrive>, drives: &[DeviceId]) {
        let is_alarmed = |id| self.alarm.iter().flatten().any(|&alarmed| alarmed == id);
        for &drive in drives {
            let drive = bench.device_mut(drive);
            let has_alarm = drive.id().is_some_and(is_alarmed);
            let faults = drive.faults_mut();
            if has_alarm {
                faults.raise_alarm(Alarm::OverCurrent);
            }
            if let Some(settings) = self.ignore_settings_after {
                faults.ignore_settings_after(settings);
            }
        }
    }
}

/// What is at a place, where the user wants it.
fn create<T>(
    place: Option<&Place>,
    create: impl FnOnce(&Place) -> io::Result<T>,
) -> Result<Option<T>, BenchError> {
    place
        .map(|place| {
            create(place).map_err(|source| BenchError::Create {
                place: place.clone(),
                source,
            })
        })
        .transpose()
}
