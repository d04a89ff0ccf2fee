//! The bus plan: whether a bus carries its axes.

mod rows;

use can_motion::plan::{BitRate, BusPlan, BusSetup, RequestMix, ResponseWindow, TxOrder};
use can_motion::{AxisConfig, Limits, MasterConfig, PollPeriods, StepChange, Travel};
use dyn_can::{DriveId, GearNumber, StepLimit};
use pyo3::prelude::*;
use pythonize::pythonize;
use serde::Serialize;

use crate::errors::input_error;
use rows::{Row, rows};

/// What is to be planned; the names are those of the arguments in Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wish {
    drives: Vec<i32>,
    bit_rate_kbit: u32,
    cycle_us: u32,
    max_step_counts: i32,
    status_hz: u32,
    position_hz: u32,
    torque_hz: u32,
    speed_hz: u32,
    counter_hz: u32,
    requests: u8,
    response_us: (u32, u32),
    tx_order: String,
    any_request: bool,
    release_jitter_us: u32,
    alarms: u8,
    error_interval_us: Option<u32>,
}

/// The verdict, with the names of `motionctl plan --json`.
#[derive(Serialize)]
struct Verdict {
    schedulable: bool,
    refusal: Option<String>,
    remedies: Option<String>,
    warnings: Vec<String>,
    frames: Vec<Row>,
    load_bits: u64,
    cycle_bits: u64,
    most_axes: usize,
    requests_behind: Option<u8>,
}

/// Works out a plan.
#[pyfunction]
pub(crate) fn plan(py: Python<'_>, wish: Wish) -> PyResult<Bound<'_, PyAny>> {
    let config = wish.config().map_err(|text| input_error(py, text))?;
    let axes = wish.axes().map_err(|text| input_error(py, text))?;
    let verdict = py.detach(|| {
        let most_axes = most_axes(&config, &wish);
        let plan = BusPlan::new(&config, &axes);
        Verdict::new(&plan, most_axes)
    });
    Ok(pythonize(py, &verdict)?)
}

/// The bit rate of a number, if the drives know it.
pub(crate) fn bit_rate(kbit: u32) -> Result<BitRate, String> {
    let rate = BitRate::from_kbit_per_s(kbit).ok();
    rate.filter(|rate| dyn_can::knows_bit_rate(*rate))
        .ok_or_else(|| {
            format!("bit_rate_kbit: expected 10, 20, 50, 125, 250, 500, 800 or 1000, got {kbit}")
        })
}

impl Wish {
    fn config(&self) -> Result<MasterConfig, String> {
        let cycles = 250..=1_000_000;
        if !cycles.contains(&self.cycle_us) {
            return Err(format!(
                "cycle_us: expected 250 to 1000000, got {}",
                self.cycle_us
            ));
        }
        if self.requests == 0 {
            return Err("requests: expected 1 to 255, got 0".to_owned());
        }
        let (min_us, max_us) = self.response_us;
        if min_us > max_us {
            return Err(format!(
                "response_us: expected the shortest and the longest, got {min_us} and {max_us}"
            ));
        }
        if self.error_interval_us == Some(0) {
            return Err("error_interval_us: expected at least 1 or None, got 0".to_owned());
        }
        let bus = BusSetup {
            bit_rate: bit_rate(self.bit_rate_kbit)?,
            order: match self.tx_order.as_str() {
                "fifo" => TxOrder::Fifo,
                "identifier" => TxOrder::Identifier,
                other => {
                    return Err(format!(
                        "tx_order: expected fifo or identifier, got {other}"
                    ));
                }
            },
            response: ResponseWindow { min_us, max_us },
            requests: if self.any_request {
                RequestMix::Any
            } else {
                RequestMix::Polls
            },
            release_jitter_us: self.release_jitter_us,
            alarm_burst: self.alarms,
            error_interval_us: self.error_interval_us,
            canopen: None,
        };
        Ok(MasterConfig {
            cycle_us: self.cycle_us,
            requests_per_cycle: self.requests,
            bus,
            ..MasterConfig::DEFAULT
        })
    }

    fn axes(&self) -> Result<Vec<AxisConfig>, String> {
        let mut drives = Vec::new();
        for &drive in &self.drives {
            let drive = DriveId::new(drive).map_err(|error| format!("drives: {error}"))?;
            if drives.contains(&drive) {
                return Err(format!(
                    "drives: expected each drive once, got {drive} twice"
                ));
            }
            drives.push(drive);
        }
        if drives.is_empty() {
            return Err("drives: expected at least one, got none".to_owned());
        }
        drives.sort_unstable();
        drives.into_iter().map(|drive| self.axis(drive)).collect()
    }

    fn axis(&self, drive: DriveId) -> Result<AxisConfig, String> {
        let max_step = StepLimit::new(self.max_step_counts)
            .map_err(|error| format!("max_step_counts: {error}"))?;
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        let limits = Limits::new(max_step, StepChange::MAX, Travel::WHOLE);
        Ok(AxisConfig {
            unwatched: self.status_hz == 0,
            polls: PollPeriods {
                status_us: period_us(self.status_hz),
                position_us: period_us(self.position_hz),
                torque_us: period_us(self.torque_hz),
                speed_us: period_us(self.speed_hz),
                counter_us: period_us(self.counter_hz),
            },
            // No frame depends on the gear.
            ..AxisConfig::new(drive, GearNumber::MAX, limits)
        })
    }
}

/// The largest number of axes of the same kind, from drive 1 on.
fn most_axes(config: &MasterConfig, wish: &Wish) -> usize {
    let axes: Vec<AxisConfig> = DriveId::all()
        .map_while(|drive| wish.axis(drive).ok())
        .collect();
    let fits = |count: &usize| {
        let some = axes.get(..*count).unwrap_or_default();
        BusPlan::new(config, some).check().is_ok()
    };
    (1..=axes.len()).take_while(fits).last().unwrap_or(0)
}

impl Verdict {
    fn new(plan: &BusPlan<'_>, most_axes: usize) -> Self {
        let refusal = plan.check().err();
        let warnings = plan.cycle().warnings();
        Self {
            schedulable: refusal.is_none(),
            refusal: refusal.map(|refusal| refusal.to_string()),
            remedies: refusal.map(|_| plan.remedies().to_string()),
            warnings: warnings.iter().flatten().map(ToString::to_string).collect(),
            frames: rows(plan),
            load_bits: plan.cycle().load_bits(),
            cycle_bits: plan.cycle().cycle_bits(),
            most_axes,
            requests_behind: plan.requests_behind(),
        }
    }
}
