//! `motionctl plan`: whether a bus carries its axes, worked out before anything moves.

mod arguments;
mod error;
mod json;
mod picture;
mod svg;
mod table;
mod text;

use std::process::ExitCode;

use can_motion::plan::BusPlan;
use can_motion::{AxisConfig, MasterConfig};
use dyn_can::DriveId;

use crate::exit;
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
        println!(
            "{}",
            serde_json::to_string_pretty(&verdict).map_err(PlanError::Json)?
        );
    } else {
        print(&plan, most_axes, &picture);
    }
    Ok(match plan.check() {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => exit::BROKEN_PROMISE.into(),
    })
}

fn print(plan: &BusPlan<'_>, most_axes: usize, picture: &Picture) {
    println!("{}", table::of(plan));
    let (load, cycle) = (plan.load_bits(), plan.cycle_bits());
    let percent = 100.0 * load as f64 / cycle as f64;
    print!("a full cycle carries {load} of {cycle} bit times, {percent:.1} %");
    match cycle.checked_sub(load) {
        Some(headroom) => println!("; headroom {headroom} bit times"),
        None => println!("; {} too many", load - cycle),
    }
    println!("with drives 1, 2, 3 ... and these polls at most {most_axes} axes fit\n");
    println!("{}", text::draw(picture));
    for warning in plan.warnings().into_iter().flatten() {
        println!("note: {warning}");
    }
    match plan.check() {
        Ok(()) => println!("Every frame is in time, whatever it carries."),
        Err(refusal) if plan.remedies() == can_motion::plan::Remedies::default() => {
            println!("REFUSED: {refusal}");
        }
        Err(refusal) => println!("REFUSED: {refusal}; {}", plan.remedies()),
    }
}

/// The largest number of axes of the same kind, from drive 1 on.
fn most_axes(config: &MasterConfig, arguments: &Arguments) -> usize {
    let axes: Vec<AxisConfig> = DriveId::all().map(|drive| arguments.axis(drive)).collect();
    let fits = |count: &usize| BusPlan::new(config, &axes[..*count]).check().is_ok();
    (1..=axes.len()).take_while(fits).last().unwrap_or(0)
}
