//! The pictures, as SVG in the colours of the palette.

mod axis;
mod bus;
mod jitter;

use core::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::palette;
use crate::sim::recording::{Happening, Recording, Sample};

pub(super) use axis::axis;
pub(super) use bus::bus;
pub(super) use jitter::jitter;

/// Width of every picture, and its part left of the time axis.
const WIDTH: u32 = 1_100;
const LABELS: u32 = 92;
/// Columns in which a curve keeps its extremes.
const COLUMNS: u32 = WIDTH - LABELS;
/// Height of the time labels under the lowest panel.
const TIME_LABELS: u32 = 42;
const FONT: (&str, i32) = ("sans-serif", 15);

/// The result, or why a picture cannot be drawn.
type Drawn<T> = Result<T, String>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn reason(error: impl core::fmt::Display) -> String {
    error.to_string()
}

fn seconds(sample: &Sample) -> f64 {
    sample.at_us as f64 * 1e-6
}

fn at_s(happening: &Happening) -> f64 {
    happening.at_us as f64 * 1e-6
}

fn font<'a>() -> TextStyle<'a> {
    FONT.into_font().color(&palette::INK)
}

/// Coordinates over the time of the whole run.
fn time_chart<'a, 'b>(
    area: &'a Area<'b>,
    recording: &Recording,
    values: Range<f64>,
    label_height: u32,
) -> Drawn<Chart<'a, 'b>> {
    ChartBuilder::on(area)
        .margin_top(8)
        .margin_bottom(4)
        .margin_right(14)
        .x_label_area_size(label_height)
        .y_label_area_size(LABELS)
        .build_cartesian_2d(0.0..recording.end_s().max(1e-3), values)
        .map_err(reason)
}

/// Grid and labels. Without `labels` there are no values to read, as for rows of events.
fn mesh(chart: &mut Chart<'_, '_>, values: &str, time: &str, labels: usize) -> Drawn<()> {
    let mut mesh = chart.configure_mesh();
    if labels == 0 {
        mesh.disable_y_mesh();
    }
    mesh.x_desc(time)
        .y_desc(values)
        .x_labels(14)
        .y_labels(labels)
        .label_style(font())
        .axis_desc_style(font())
        .axis_style(palette::INK)
        .bold_line_style(palette::GRID)
        .light_line_style(palette::GRID.mix(0.0))
        .x_label_formatter(&|s| format!("{s:.1}"))
        .y_label_formatter(&|value| grouped(*value))
        .draw()
        .map_err(reason)
}

/// A whole number with a thin space between thousands, others with one decimal.
fn grouped(value: f64) -> String {
    if value.fract().abs() > 1e-9 {
        return format!("{value:.1}");
    }
    let digits = format!("{:.0}", value.abs());
    let mut text = String::from(if value < 0.0 { "-" } else { "" });
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_apart() {
        let texts = [0.0, 999.0, -1_000.0, 1_234_567.0, 2.5].map(grouped);
        assert_eq!(
            texts,
            [
                "0",
                "999",
                "-1\u{2009}000",
                "1\u{2009}234\u{2009}567",
                "2.5"
            ]
        );
    }
}
