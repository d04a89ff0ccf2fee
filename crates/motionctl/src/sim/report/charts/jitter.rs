//! How far the set-points of each axis are from an even rhythm.

use plotters::prelude::*;

use super::{Drawn, LABELS, TIME_LABELS, WIDTH, font, reason};
use crate::sim::recording::Recording;
use crate::sim::report::histogram::Histogram;
use crate::sim::report::palette;

/// Where the logarithmic axis of the counts begins: below a single one.
const LEAST_COUNT: f64 = 0.5;
/// Free part of a bin on each side.
const GAP: f64 = 0.06;

/// A histogram of interval less cycle, with a logarithmic axis: one late set-point in a million shall be seen.
pub(in crate::sim::report) fn jitter(recording: &Recording) -> Drawn<String> {
    let histogram = Histogram::of(recording.intervals.deviations_us());
    let most = histogram.counts.iter().copied().max().unwrap_or(0).max(10);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, 260)).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin_top(10)
            .margin_right(14)
            .x_label_area_size(TIME_LABELS)
            .y_label_area_size(LABELS)
            .build_cartesian_2d(
                histogram.start..histogram.end(),
                (LEAST_COUNT..most as f64 * 2.0).log_scale(),
            )
            .map_err(reason)?;
        chart
            .configure_mesh()
            .x_desc("interval between set-points of an axis, less the cycle, us")
            .y_desc("set-points, log scale")
            .label_style(font())
            .axis_desc_style(font())
            .axis_style(palette::INK)
            .bold_line_style(palette::GRID)
            .light_line_style(palette::GRID.mix(0.0))
            .x_label_formatter(&|us| deviation(*us))
            .y_label_formatter(&|count| format!("{count:.0}"))
            .draw()
            .map_err(reason)?;
        chart.draw_series(bars(&histogram)).map_err(reason)?;
        root.present().map_err(reason)?;
    }
    Ok(text)
}

/// With its sign, but for 0.
fn deviation(us: f64) -> String {
    // Bins may be narrower than a microsecond, and no two labels may be the same.
    match us.abs() {
        size if size < 0.05 => "0".to_owned(),
        size if size < 10.0 => format!("{us:+.1}"),
        _ => format!("{us:+.0}"),
    }
}

fn bars(histogram: &Histogram) -> impl Iterator<Item = Rectangle<(f64, f64)>> {
    let filled = (0..)
        .zip(&histogram.counts)
        .filter(|(_, count)| **count > 0);
    filled.map(|(number, count): (u32, &u64)| {
        let left = histogram.start + histogram.width * f64::from(number);
        let corners = [
            (left + GAP * histogram.width, LEAST_COUNT),
            (left + (1.0 - GAP) * histogram.width, *count as f64),
        ];
        Rectangle::new(corners, palette::BUS.filled())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_narrow_bins_differ() {
        let labels = [-2.5, -1.5, -0.5, 0.0, 0.5, 12.4].map(deviation);
        assert_eq!(labels, ["-2.5", "-1.5", "-0.5", "0", "+0.5", "+12"]);
    }
}
