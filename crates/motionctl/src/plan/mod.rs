//! `motionctl plan`: whether a bus carries its axes, worked out before anything moves.

mod arguments;
mod error;
mod json;
mod picture;
mod svg;
mod table;
mod text;

use core::fmt::Write as _;
use std::io;
use std::process::ExitCode;

use can_motion::plan::BusPlan;
use can_motion::{AxisConfig, MasterConfig};
use dyn_can::DriveId;

use crate::exit;
use crate::output::{print, print_json};
pub(crate) use arguments::Arguments;
use error::PlanError;
use json::Verdict;
use picture::Picture;

/// Works out the plan, prints it, and writes the picture.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, PlanError> {
    let (config, axes) = (arguments.config(), arguments.axes());
    let plan = BusPlan::new(&config, &axes);
    let picture = Picture::new(&plan);
    if let Some(path) = &arguments.svg {
        std::fs::write(path, svg::draw(&picture)?).map_err(|source| PlanError::Write {
            path: path.clone(),
            source,
        })?;
    }
    let most_axes = most_axes(&config, arguments);
    if arguments.json {
        let verdict = Verdict::new(&plan, most_axes);
        print_json(&verdict).map_err(PlanError::Print)?;
    } else {
        let text = words(&plan, most_axes, &picture).map_err(io::Error::other);
        text.and_then(print).map_err(PlanError::Print)?;
    }
    Ok(match plan.check() {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => exit::BROKEN_PROMISE.into(),
    })
}

fn words(
    plan: &BusPlan<'_>,
    most_axes: usize,
    picture: &Picture,
) -> Result<String, core::fmt::Error> {
    let mut text = String::new();
    writeln!(text, "{}", table::of(plan))?;
    let (load, cycle) = (plan.cycle().load_bits(), plan.cycle().cycle_bits());
    let percent = 100.0 * load as f64 / cycle as f64;
    write!(
        text,
        "a full cycle carries {load} of {cycle} bit times, {percent:.1} %"
    )?;
    match cycle.checked_sub(load) {
        Some(headroom) => writeln!(text, "; headroom {headroom} bit times")?,
        None => writeln!(text, "; {} too many", load - cycle)?,
    }
    writeln!(
        text,
        "with drives 1, 2, 3 ... and these polls at most {most_axes} axes fit\n"
    )?;
    writeln!(text, "{}", text::draw(picture))?;
    for warning in plan.cycle().warnings().into_iter().flatten() {
        writeln!(text, "note: {warning}")?;
    }
    match plan.check() {
        Ok(()) => write!(text, "Every frame is in time, whatever it carries.")?,
        Err(refusal) if plan.remedies() == can_motion::plan::Remedies::default() => {
            write!(text, "REFUSED: {refusal}")?;
        }
        Err(refusal) => write!(text, "REFUSED: {refusal}; {}", plan.remedies())?,
    }
    Ok(text)
}

/// The largest number of axes of the same kind, from drive 1 on.
fn most_axes(config: &MasterConfig, arguments: &Arguments) -> usize {
    let axes: Vec<AxisConfig> = DriveId::all().map(|drive| arguments.axis(drive)).collect();
    let fits = |count: &usize| BusPlan::new(config, &axes[..*count]).check().is_ok();
    (1..=axes.len()).take_while(fits).last().unwrap_or(0)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<json::Verdict>()
}
