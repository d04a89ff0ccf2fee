//! The board on its bus: what stays over a reset, and what begins with one.

use std::io;

use board_link::board::{Board, BoardConfig, Command, Link};
use board_link::message::{BoardState, Reason, Refused};
use board_link::segment::SegmentConfig;
use board_settings::Settings;
use can_motion::Instant;
use drive_sim::{Bench, ControllerConfig, DynDrive, NodeId, TxOrder};

use super::application::App;
use super::fault_log::FaultLog;
use super::inputs::Inputs;
use super::machine::Machine;
use super::options::BoardOptions;
use super::report::BoardReport;
use super::store::Store;
use super::{AXES, Queue};
use crate::bench::BenchError;
use crate::host_port::HostPort;
use crate::output::tell;

/// What the simulated board is.
const BUILT: board_settings::Board = board_settings::Board::STM32F405;
const CYCLES_PER_SECOND: u32 = 1_000_000 / BUILT.cycle_us;
const CYCLE_NS: u64 = BUILT.cycle_us as u64 * 1_000;
/// Bytes that wait for the host.
const TO_HOST: usize = 4_096;

/// What stays over a reset.
pub(in crate::bench) struct Seat {
    port: HostPort,
    node: NodeId,
    store: Store,
    inputs: Inputs,
    faults: FaultLog,
    report: BoardReport,
    /// The number of the next start; it differs from those of the bench before.
    boot: u32,
    off_until_ns: u64,
}

/// A board from a start to a reset.
pub(in crate::bench) struct Running<'q> {
    board: Board<'q, App, AXES>,
    link: Link<TO_HOST>,
    machine: Option<Machine<'q>>,
    started_ns: u64,
    /// The number of the next cycle.
    cycle: u64,
    resets: u64,
}

impl Seat {
    /// Connects a board that is off.
    pub(in crate::bench) fn new(
        options: &BoardOptions,
        bench: &mut Bench<DynDrive>,
    ) -> Result<Option<Self>, BenchError> {
        let Some(place) = &options.board else {
            return Ok(None);
        };
        let created = |source| BenchError::Create {
            place: place.clone(),
            source,
        };
        let store = Store::open(options.settings.as_deref()).map_err(|source| {
            let path = options.settings.clone().unwrap_or_default();
            BenchError::Settings { path, source }
        })?;
        Ok(Some(Self {
            port: HostPort::create(place, "the board").map_err(created)?,
            node: bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo)),
            store,
            inputs: Inputs::new(options).map_err(BenchError::Interrupt)?,
            faults: FaultLog::default(),
            report: BoardReport::default(),
            boot: first_boot(),
            off_until_ns: 0,
        }))
    }

    pub(in crate::bench) const fn port(&self) -> &HostPort {
        &self.port
    }

    pub(in crate::bench) const fn node(&self) -> NodeId {
        self.node
    }

    pub(in crate::bench) const fn report(&self) -> BoardReport {
        self.report
    }

    /// It has no power until then.
    pub(in crate::bench) const fn power_off_until(&mut self, until_ns: u64) {
        self.off_until_ns = until_ns;
        self.inputs.reset();
    }

    /// A start.
    pub(in crate::bench) fn start<'q>(
        &mut self,
        queue: &'q mut Queue,
        bench: &mut Bench<DynDrive>,
    ) -> Running<'q> {
        self.boot = self.boot.wrapping_add(1);
        // What waited in its controller is gone.
        bench.port(self.node).power_off();
        bench.port(self.node).power_on();
        let app = App::new(BUILT, self.boot, self.store.bytes(), self.faults.clone());
        let (admission, machine) = match self.configs(bench) {
            None => (None, None),
            Some(configs) => {
                let config = SegmentConfig::with_cycles_per_second(CYCLES_PER_SECOND);
                let halves = queue.split(&configs.limits, config);
                let machine = |(admission, player)| {
                    let machine = Machine::new(configs, player).ok()?;
                    Some((admission, machine))
                };
                match halves.and_then(machine) {
                    Some((admission, machine)) => (Some(admission), Some(machine)),
                    None => (None, None),
                }
            }
        };
        let config = BoardConfig::with_cycles_per_second(CYCLES_PER_SECOND);
        Running {
            board: Board::new(app, admission, config),
            link: Link::new(),
            machine,
            started_ns: bench.now_ns().max(self.off_until_ns),
            cycle: 0,
            resets: self.inputs.resets(),
        }
    }

    /// The settings, where they make a board that works, and say so where they do not.
    fn configs(&self, bench: &Bench<DynDrive>) -> Option<board_settings::Configs> {
        let settings = self.store.settings()?;
        let configs = settings
            .configs(&BUILT)
            .inspect_err(|refusal| {
                tell(format_args!(
                    "note: the board refuses its settings: {refusal}"
                ));
            })
            .ok()?;
        let (says, is) = (
            configs.master.bus.bit_rate.kbit_per_s(),
            bench.bus().bit_rate().kbit_per_s(),
        );
        if says != is {
            tell(format_args!(
                "note: the settings of the board say {says} kbit/s, the bus runs at {is} kbit/s: nothing gets through"
            ));
        }
        Some(configs)
    }

    /// Ends what runs; its report is kept.
    pub(in crate::bench) fn end(&mut self, running: Running<'_>) {
        let Running {
            mut board,
            link,
            cycle,
            ..
        } = running;
        let counters = link.counters(&mut board);
        self.report.add(cycle, &counters);
    }
}

/// The time says it: no start before this one had that number.
fn first_boot() -> u32 {
    let since_1970 = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since_1970.map_or(0, |time| time.as_secs() as u32)
}

impl Running<'_> {
    /// Whether it was reset.
    pub(in crate::bench) fn is_reset(&self, seat: &mut Seat) -> bool {
        seat.inputs.update();
        self.resets != seat.inputs.resets()
    }

    /// When the next cycle begins.
    pub(in crate::bench) const fn next_cycle_ns(&self) -> u64 {
        self.started_ns + self.cycle * CYCLE_NS
    }

    /// Since its start, as its clock says.
    fn now(&self, bench: &Bench<DynDrive>) -> Instant {
        Instant::from_us(bench.now_ns().saturating_sub(self.started_ns) / 1_000)
    }

    /// Hands frames both ways.
    pub(in crate::bench) fn serve(&mut self, seat: &Seat, bench: &mut Bench<DynDrive>) {
        let now = self.now(bench);
        if self.cycle > 0
            && let Some(machine) = &mut self.machine
            && machine.kbit_per_s() == bench.bus().bit_rate().kbit_per_s()
        {
            machine.serve(now, bench, seat.node);
        }
    }

    /// Begins a cycle.
    pub(in crate::bench) fn begin_cycle(
        &mut self,
        seat: &mut Seat,
        bench: &Bench<DynDrive>,
    ) -> io::Result<()> {
        self.exchange(seat)?;
        let (now, number) = (self.now(bench), self.cycle);
        self.cycle += 1;
        let app = self.board.application();
        save_settings(app, &mut seat.store, self.machine.as_ref())?;
        match &mut self.machine {
            Some(machine) => {
                let switch = |drive| {
                    let mut devices = bench.devices();
                    let of = devices.find(|device| device.id() == Some(drive));
                    of.is_some_and(|device| device.switch_is_operated(bench.now_ns()))
                };
                machine.cycle((now, number), seat.inputs.levels(), app, switch);
            }
            None => refuse_all(app),
        }
        Ok(())
    }

    /// Bytes both ways; whether some wait for a host that reads too slowly.
    pub(in crate::bench) fn exchange(&mut self, seat: &mut Seat) -> io::Result<bool> {
        let mut buffer = [0; 4_096];
        let bytes = seat.port.read(&mut buffer)?;
        if self.cycle == 0 {
            // It has not started.
            return Ok(false);
        }
        // The cycle that was begun last.
        let now = self.cycle.saturating_sub(1);
        self.link.on_bytes(&mut self.board, now, bytes);
        self.link.poll(&mut self.board, now);
        let written = seat.port.write(self.link.output())?;
        self.link.consume(written);
        Ok(!self.link.output().is_empty())
    }
}

/// Stores what the host wants to have stored, while nothing is enabled.
fn save_settings(
    app: &mut App,
    store: &mut Store,
    machine: Option<&Machine<'_>>,
) -> io::Result<()> {
    let is_save = |(_, command): &(u16, Command)| matches!(command, Command::SaveSettings { .. });
    while let Some(place) = app.commands.iter().position(is_save) {
        let Some((ticket, Command::SaveSettings { length })) = app.commands.remove(place) else {
            return Ok(());
        };
        let result: Result<Settings, Refused> = if machine.is_some_and(Machine::is_powered) {
            Err(Reason::Enabled.plain())
        } else {
            Settings::read(app.staged(length)).map_err(Into::into)
        };
        let result = match result {
            Ok(settings) => {
                store.save(settings).map_err(io::Error::other)?;
                Ok(())
            }
            Err(refused) => Err(refused),
        };
        app.results.push_back((ticket, result));
    }
    Ok(())
}

/// A board without settings moves nothing.
fn refuse_all(app: &mut App) {
    let (expected, actual) = (BoardState::Off as i64, BoardState::NoSettings as i64);
    for (ticket, _) in app.commands.drain(..) {
        let refused = Reason::NotReady.because(expected, actual);
        app.results.push_back((ticket, Err(refused)));
    }
}
