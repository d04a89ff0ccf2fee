//! A board without a machine, for tests: the board's end of the link and its player, axes that follow at once, on a TCP port of this machine.

mod machine;
mod run;

use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;

use board_link::AxisLimits;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use trajectory::{Limits, Position};

use crate::errors::input_error;

/// Axes that a board can have.
const MOST_AXES: usize = board_link::segment::MOST_AXES;
/// Set-points that are kept: two minutes of two axes at 1 kHz.
const MOST_TRACE: usize = 240_000;

/// What a test says and asks.
#[derive(Debug)]
struct Wishes {
    is_closing: bool,
    is_reset: bool,
    /// The host is cut off.
    is_dropped: bool,
    is_stop_open: bool,
    is_enable_inactive: bool,
    fault: Option<(u8, u16, i32)>,
    /// Cycle, then each axis in units of 2^-24 counts.
    trace: Vec<i64>,
    trace_lost: u64,
    positions: Vec<i32>,
}

/// What a board is made of.
#[derive(Debug, Clone)]
struct Made {
    limits: Vec<AxisLimits>,
    settings: Vec<u8>,
    silence_cycles: u32,
    cycle_us: u32,
    /// Where the axes that are to be homed find their origins.
    origins: Vec<Option<i32>>,
}

/// The board, in a thread of its own, in real time.
#[pyclass(module = "motion_board._native", frozen)]
pub(crate) struct SimulatedBoard {
    address: SocketAddr,
    axes: usize,
    wishes: Arc<Mutex<Wishes>>,
    thread: Mutex<Option<JoinHandle<()>>>,
    /// The process in which the thread runs.
    process: u32,
}

#[pymethods]
impl SimulatedBoard {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "Python names them")]
    fn new(
        py: Python<'_>,
        axes: usize,
        velocity: f32,
        acceleration: f32,
        jerk: Option<f32>,
        travel: (i32, i32),
        cycle_us: u32,
        silence_cycles: u32,
        settings: Vec<u8>,
        port: u16,
        origins: Vec<Option<i32>>,
    ) -> PyResult<Self> {
        if axes == 0 || axes > MOST_AXES {
            let text = format_args!("axes: expected 1 to {MOST_AXES}, got {axes}");
            return Err(input_error(py, text));
        }
        if !(100..=100_000).contains(&cycle_us) {
            let text = format_args!("cycle_us: expected 100 to 100000, got {cycle_us}");
            return Err(input_error(py, text));
        }
        let motion = match jerk {
            Some(jerk) => Limits::new(velocity, acceleration, jerk),
            None => Limits::without_jerk(velocity, acceleration),
        };
        let motion = motion.map_err(|error| input_error(py, error))?;
        let (lowest, highest) = travel;
        if lowest > highest {
            let text =
                format_args!("travel: expected the lowest first, got {lowest} and {highest}");
            return Err(input_error(py, text));
        }
        if origins.len() > axes {
            let text = format_args!(
                "origins: expected {axes} at most, one of each axis, got {}",
                origins.len()
            );
            return Err(input_error(py, text));
        }
        let limits = AxisLimits {
            motion,
            lowest: Position::from_counts(lowest),
            highest: Position::from_counts(highest),
        };
        let listen = || {
            let listener = TcpListener::bind(("127.0.0.1", port))?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok((listener, address))
        };
        let listening: std::io::Result<_> = listen();
        let (listener, address) = listening?;
        let wishes = Arc::new(Mutex::new(Wishes {
            is_closing: false,
            is_reset: false,
            is_dropped: false,
            is_stop_open: false,
            is_enable_inactive: false,
            fault: None,
            trace: Vec::new(),
            trace_lost: 0,
            positions: vec![0; axes],
        }));
        let made = Made {
            limits: vec![limits; axes],
            settings,
            silence_cycles,
            cycle_us,
            origins,
        };
        let shared = Arc::clone(&wishes);
        let builder = std::thread::Builder::new().name("simulated board".to_owned());
        let thread = builder.spawn(move || run::run(&listener, &made, &shared))?;
        Ok(Self {
            address,
            axes,
            wishes,
            thread: Mutex::new(Some(thread)),
            process: std::process::id(),
        })
    }

    /// Where a program finds it.
    #[getter]
    fn address(&self) -> String {
        format!("tcp:{}", self.address)
    }

    #[getter]
    fn axes(&self) -> usize {
        self.axes
    }

    /// Where the axes stand, in counts.
    fn positions(&self) -> Vec<i32> {
        self.wishes().positions.clone()
    }

    /// Every set-point since the start, or since the last call with `clear`: cycle, then each axis in units of 2^-24 counts, as bytes of
    /// 64-bit numbers; and how many were not kept.
    fn trace<'py>(&self, py: Python<'py>, clear: bool) -> (Bound<'py, PyBytes>, u64) {
        let mut wishes = self.wishes();
        let bytes: Vec<u8> = wishes
            .trace
            .iter()
            .flat_map(|number| number.to_ne_bytes())
            .collect();
        let lost = wishes.trace_lost;
        if clear {
            wishes.trace.clear();
            wishes.trace_lost = 0;
        }
        drop(wishes);
        (PyBytes::new(py, &bytes), lost)
    }

    /// Opens or closes the stop circuit.
    fn set_stop_circuit_open(&self, is_open: bool) {
        self.wishes().is_stop_open = is_open;
    }

    /// Makes the enable input active or not.
    fn set_enable_input_active(&self, is_active: bool) {
        self.wishes().is_enable_inactive = !is_active;
    }

    /// A fault of an axis in the next cycle.
    fn raise_fault(&self, py: Python<'_>, axis: u8, code: u16, detail: i32) -> PyResult<()> {
        if usize::from(axis) >= self.axes || code == 0 {
            let text = format_args!(
                "expected an axis below {} and a code from 1, got {axis} and {code}",
                self.axes
            );
            return Err(input_error(py, text));
        }
        self.wishes().fault = Some((axis, code, detail));
        Ok(())
    }

    /// As if the board were switched off and on.
    fn reset(&self) {
        self.wishes().is_reset = true;
    }

    /// Cuts the host off, as if the cable were pulled.
    fn drop_link(&self) {
        self.wishes().is_dropped = true;
    }

    /// Ends the board.
    fn close(&self, py: Python<'_>) {
        if !self.is_here() {
            // The thread is none of this process.
            return;
        }
        self.wishes().is_closing = true;
        let thread = self.thread.lock().map_or(None, |mut thread| thread.take());
        if let Some(thread) = thread {
            py.detach(|| {
                // A thread that panicked is gone all the same.
                let _ = thread.join();
            });
        }
    }
}

impl SimulatedBoard {
    /// Whether this is the process that has started it, and no child that was forked.
    fn is_here(&self) -> bool {
        self.process == std::process::id()
    }

    fn wishes(&self) -> MutexGuard<'_, Wishes> {
        lock(&self.wishes)
    }
}

impl Drop for SimulatedBoard {
    fn drop(&mut self) {
        if self.is_here() {
            self.wishes().is_closing = true;
        }
    }
}

fn lock(wishes: &Mutex<Wishes>) -> MutexGuard<'_, Wishes> {
    wishes
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}
