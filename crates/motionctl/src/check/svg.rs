//! Positions and speeds of every axis as SVG, with their limits.

use plotters::prelude::*;

use super::report::{AxisReport, Report};
use crate::trajectory::Plan;

const WIDTH: u32 = 900;
/// Height of the two charts of an axis together.
const HEIGHT: u32 = 260;
/// Most points of a curve: more than there are pixels.
const MOST_POINTS: usize = 1_200;
const POSITION: RGBColor = RGBColor(70, 120, 190);
const SPEED: RGBColor = RGBColor(176, 98, 0);
const LIMIT: RGBColor = RGBColor(190, 40, 40);

/// A curve over time, in seconds.
type Curve = Vec<(f64, f64)>;

/// The text of the file.
pub(super) fn draw(plan: &Plan, report: &Report, cycle_us: u32) -> Result<String, String> {
    let mut text = String::new();
    let size = (WIDTH, HEIGHT * report.axes.len() as u32);
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(reason)?;
        let rows = root.split_evenly((report.axes.len(), 1));
        for ((place, axis), area) in report.axes.iter().enumerate().zip(&rows) {
            let positions: Vec<i32> = plan.rows().map(|row| row[place]).collect();
            let halves = area.split_evenly((1, 2));
            let (turns, rpm) = curves(&positions, axis, cycle_us);
            let limit = |quantity: &str| {
                let need = axis.needs.iter().find(|need| need.quantity == quantity);
                need.map_or(0.0, |need| need.allowed)
            };
            let title = |what: &str| format!("drive {}: {what}", axis.drive);
            let of = [
                (title("turns of the motor"), turns, POSITION, limit("way")),
                (title("speed in r/min"), rpm, SPEED, limit("speed")),
            ];
            for ((title, curve, color, limit), half) in of.into_iter().zip(&halves) {
                chart(half, &title, curve, color, limit)?;
            }
        }
        root.present().map_err(reason)?;
    }
    Ok(text)
}

/// Turns and speed over time; each point of a long motion stands for the largest of its stretch.
fn curves(positions: &[i32], axis: &AxisReport, cycle_us: u32) -> (Curve, Curve) {
    let turn = f64::from(axis.counts_per_turn);
    let cycle_s = f64::from(cycle_us) * 1e-6;
    // Speeds are means over 20 ms, as everywhere.
    let window = (20_000 / cycle_us as usize).max(1);
    let at = |cycle: usize| f64::from(positions[cycle.min(positions.len() - 1)]) / turn;
    let every = positions.len().div_ceil(MOST_POINTS);
    let mut turns = Vec::new();
    let mut rpm = Vec::new();
    for start in (0..positions.len()).step_by(every) {
        let time_s = start as f64 * cycle_s;
        turns.push((time_s, at(start)));
        let speed = |cycle: usize| {
            let before = cycle.saturating_sub(window);
            (at(cycle) - at(before)) / (window as f64 * cycle_s) * 60.0
        };
        let fastest = (start..start + every)
            .map(speed)
            .fold(
                0.0_f64,
                |most, one| if one.abs() > most.abs() { one } else { most },
            );
        rpm.push((time_s, fastest));
    }
    let end_s = (positions.len() - 1) as f64 * cycle_s;
    turns.push((end_s, at(positions.len() - 1)));
    (turns, rpm)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn chart(
    area: &Area<'_>,
    title: &str,
    curve: Curve,
    color: RGBColor,
    limit: f64,
) -> Result<(), String> {
    let end_s = curve.last().map_or(1.0, |point| point.0).max(1e-3);
    let most = curve.iter().map(|point| point.1.abs()).fold(0.0, f64::max);
    // A limit that is far away would flatten the curve.
    let shows_limit = limit <= 3.0 * most;
    let height = if shows_limit { most.max(limit) } else { most }.max(1e-3) * 1.1;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16))
        .margin(8)
        .x_label_area_size(28)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..end_s, -height..height)
        .map_err(reason)?;
    chart
        .configure_mesh()
        .x_desc("s")
        .light_line_style(TRANSPARENT)
        .draw()
        .map_err(reason)?;
    if shows_limit {
        for limit in [limit, -limit] {
            let line = [(0.0, limit), (end_s, limit)];
            chart
                .draw_series(LineSeries::new(line, LIMIT))
                .map_err(reason)?;
        }
    }
    chart
        .draw_series(LineSeries::new(curve, color))
        .map_err(reason)?;
    Ok(())
}

fn reason(error: impl core::fmt::Display) -> String {
    error.to_string()
}
