//! What a motion needs, against what it may use.

use core::fmt;

use can_motion::plan::{BusPlan, BusSetup};
use can_motion::{AxisConfig, MasterConfig};
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::{DriveId, GearNumber};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Arguments;
use crate::station::Needs;
use crate::table::align_numbers;
use crate::trajectory::Plan;

/// What a motion would do.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// `run` would take it.
    pub(super) would_run: bool,
    pub(super) cycles: usize,
    pub(super) duration_s: f64,
    pub(super) axes: Vec<AxisReport>,
    pub(super) bus: BusReport,
    /// Why `run` would refuse it.
    pub(super) problems: Vec<String>,
}

/// An axis against its limits.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct AxisReport {
    pub(super) drive: u8,
    /// Counts of a motor turn.
    pub(super) counts_per_turn: u32,
    pub(super) needs: Vec<Need>,
}

/// A quantity of the motor against its limit.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Need {
    pub(super) quantity: &'static str,
    pub(super) unit: &'static str,
    pub(super) needed: f64,
    pub(super) allowed: f64,
    /// The option of the limit.
    pub(super) option: &'static str,
}

/// The bus in a full cycle.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct BusReport {
    pub(super) bit_rate_kbit_per_s: u32,
    pub(super) load_percent: f64,
    pub(super) is_in_time: bool,
}

impl Report {
    pub(super) fn new(
        arguments: &Arguments,
        plan: &Plan,
        drives: &[DriveId],
        gears: &[GearNumber],
    ) -> Self {
        let needs: Vec<Needs> = gears
            .iter()
            .enumerate()
            .map(|(axis, &gear)| {
                let positions: Vec<i32> = plan.rows().map(|row| row[axis]).collect();
                Needs::of(&positions, gear, arguments.cycle_us)
            })
            .collect();
        let mut problems: Vec<String> = Vec::new();
        let mut axes = Vec::new();
        for ((needs, &drive), &gear) in needs.iter().zip(drives).zip(gears) {
            problems.extend(
                arguments
                    .limits
                    .exceeded(drive, needs)
                    .map(|error| error.to_string()),
            );
            let quantities = arguments.limits.quantities(needs);
            axes.push(AxisReport {
                drive: drive.get(),
                counts_per_turn: dyn_can::units::command_counts_per_turn(gear),
                needs: quantities
                    .into_iter()
                    .map(|quantity| Need {
                        quantity: quantity.name,
                        unit: quantity.unit,
                        needed: quantity.needs,
                        allowed: quantity.allowed,
                        option: quantity.option,
                    })
                    .collect(),
            });
        }
        let (bus, refusal) = bus(arguments, &needs, drives, gears);
        problems.extend(refusal);
        Self {
            would_run: problems.is_empty(),
            cycles: plan.cycles(),
            duration_s: (plan.cycles() - 1) as f64 * f64::from(arguments.cycle_us) * 1e-6,
            axes,
            bus,
            problems,
        }
    }
}

/// The plan of the bus as `run` has it, and why it is refused.
fn bus(
    arguments: &Arguments,
    needs: &[Needs],
    drives: &[DriveId],
    gears: &[GearNumber],
) -> (BusReport, Option<String>) {
    let axis = |((needs, &drive), &gear)| {
        let limits = arguments.limits.of_axis(needs, 0, gear, arguments.cycle_us);
        arguments.axes.axis(drive, gear, limits, arguments.polls())
    };
    let mut axes: Vec<AxisConfig> = needs.iter().zip(drives).zip(gears).map(axis).collect();
    axes.sort_unstable_by_key(|axis| axis.drive);
    let kbit = arguments.bit_rate.kbit_per_s();
    let config = MasterConfig {
        cycle_us: arguments.cycle_us,
        bus: BusSetup {
            bit_rate: can_motion::plan::BitRate::from_kbit_per_s(kbit)
                .unwrap_or(can_motion::plan::BitRate::Kbit1000),
            ..BusSetup::DEFAULT
        },
        ..MasterConfig::DEFAULT
    };
    let plan = BusPlan::new(&config, &axes);
    let (load, cycle) = (plan.cycle().load_bits(), plan.cycle().cycle_bits());
    let refusal = plan.check().err().map(|refusal| refusal.to_string());
    let report = BusReport {
        bit_rate_kbit_per_s: kbit,
        load_percent: 100.0 * load as f64 / cycle as f64,
        is_in_time: refusal.is_none(),
    };
    (report, refusal.map(|refusal| format!("the bus: {refusal}")))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "drive",
            "of the motor",
            "needed",
            "allowed",
            "used\n%",
            "option",
        ]);
        for axis in &self.axes {
            for need in &axis.needs {
                table.add_row([
                    axis.drive.to_string(),
                    format!("{} in {}", need.quantity, need.unit),
                    format!("{:.2}", need.needed),
                    need.allowed.to_string(),
                    format!("{:.0}", 100.0 * need.needed / need.allowed),
                    need.option.to_owned(),
                ]);
            }
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        writeln!(
            f,
            "{:.3} s in {} cycles; a full cycle loads the bus of {} kbit/s by {:.1} %",
            self.duration_s, self.cycles, self.bus.bit_rate_kbit_per_s, self.bus.load_percent
        )?;
        for problem in &self.problems {
            writeln!(f, "REFUSED: {problem}")?;
        }
        f.write_str(if self.would_run {
            "`motionctl run` would take it."
        } else {
            "`motionctl run` would refuse it."
        })
    }
}
