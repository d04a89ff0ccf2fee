//! The path of a program as SVG, seen from above.

use plotters::prelude::*;

use super::check::Checked;
use super::error::ProgramFileError;

/// Points of the drawn path at most.
const MOST_POINTS: usize = 8_000;
const WIDTH: f64 = 640.0;
const LABELS: f64 = 56.0;
/// Height over width at most, and at least.
const SHAPES: (f64, f64) = (0.3, 1.5);

type Point = (f64, f64);

/// The text of the file: the set-points of the first two axes in millimetres.
pub(super) fn draw(checked: &Checked) -> Result<String, ProgramFileError> {
    let points = points(checked)?;
    let mut text = String::new();
    on(&points, &mut text)
        .map_err(|reason| ProgramFileError::Option(format!("cannot draw the path: {reason}")))?;
    Ok(text)
}

fn points(checked: &Checked) -> Result<Vec<Point>, ProgramFileError> {
    let mut player = checked.player()?;
    let stride = checked.cycles.div_ceil(MOST_POINTS).max(1);
    let mut points = vec![(0.0, 0.0)];
    let mut cycle = 0;
    let mm = |player: &super::Player| {
        let [x, y, _] = player
            .place()
            .map(|place| place.units() as f64 / 16_777_216.0 / 1e3);
        (x, y)
    };
    while player.next()?.is_some() {
        cycle += 1;
        if cycle % stride == 0 {
            points.push(mm(&player));
        }
    }
    points.push(mm(&player));
    Ok(points)
}

fn on(points: &[Point], text: &mut String) -> Result<(), String> {
    let range = |of: fn(&Point) -> f64| {
        let values = points.iter().map(of);
        let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let margin = (0.04 * (high - low)).max(1e-3);
        (low - margin, high + margin)
    };
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    let shape = ((y.1 - y.0) / (x.1 - x.0)).clamp(SHAPES.0, SHAPES.1);
    let size = (WIDTH, LABELS + (WIDTH - LABELS) * shape);
    let (x, y) = same_scale(x, y, shape);
    let area = SVGBackend::with_string(text, (size.0 as u32, size.1 as u32)).into_drawing_area();
    area.fill(&WHITE).map_err(reason)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(12)
        .x_label_area_size(32)
        .y_label_area_size(LABELS as i32 - 12)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)
        .map_err(reason)?;
    chart
        .configure_mesh()
        .x_desc("X, mm")
        .y_desc("Y, mm")
        .light_line_style(WHITE)
        .draw()
        .map_err(reason)?;
    chart
        .draw_series(LineSeries::new(points.iter().copied(), &BLUE))
        .map_err(reason)?;
    area.present().map_err(reason)
}

/// Wider ranges, so that a millimetre is as long in both directions.
fn same_scale(x: Point, y: Point, shape: f64) -> (Point, Point) {
    let widened = |(low, high): Point, length: f64| {
        let more = (length - (high - low)).max(0.0) / 2.0;
        (low - more, high + more)
    };
    let (width, height) = (x.1 - x.0, y.1 - y.0);
    (widened(x, height / shape), widened(y, width * shape))
}

fn reason(error: impl core::fmt::Display) -> String {
    error.to_string()
}
