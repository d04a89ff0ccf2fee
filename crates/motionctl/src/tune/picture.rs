//! The answers side by side, as SVG.

use core::fmt::Display;

use plotters::prelude::*;

use super::measure::Sample;

/// Size of one panel.
const PANEL: (u32, u32) = (420, 320);
const SET_POINT: RGBColor = RGBColor(120, 120, 120);
const POSITION: RGBColor = RGBColor(70, 120, 190);
/// Room above and below the answer, as a share of it.
const ROOM: f64 = 0.1;

/// One answer.
pub(crate) struct Panel<'a> {
    pub(crate) caption: String,
    pub(crate) samples: &'a [Sample],
    /// What should be is known, and drawn too.
    pub(crate) has_set_points: bool,
}

/// The text of the file, with the values in this unit.
pub(crate) fn draw(sets: &[Panel<'_>], unit: &str) -> Result<String, String> {
    let panels = u32::try_from(sets.len().max(1)).unwrap_or(1);
    let mut text = String::new();
    {
        let area =
            SVGBackend::with_string(&mut text, (PANEL.0 * panels, PANEL.1)).into_drawing_area();
        area.fill(&WHITE).map_err(reason)?;
        let (low, high) = range(sets);
        for (set, panel) in sets.iter().zip(area.split_evenly((1, sets.len().max(1)))) {
            draw_set(set, unit, &panel, low, high)?;
        }
        area.present().map_err(reason)?;
    }
    Ok(text)
}

/// One scale for every panel, so that they can be compared.
fn range(sets: &[Panel<'_>]) -> (f64, f64) {
    let samples = sets.iter().flat_map(|set| set.samples);
    let values = samples.flat_map(|sample| [sample.set_point, sample.actual]);
    let (low, high) = values.fold((0, 0), |(low, high), value| {
        (value.min(low), value.max(high))
    });
    let room = f64::from(high - low).max(1.0) * ROOM;
    (f64::from(low) - room, f64::from(high) + room)
}

fn draw_set(
    set: &Panel<'_>,
    unit: &str,
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    low: f64,
    high: f64,
) -> Result<(), String> {
    let end_ms = set
        .samples
        .last()
        .map_or(1.0, |sample| sample.at_ms)
        .max(1.0);
    let start_ms = set
        .samples
        .first()
        .map_or(0.0, |sample| sample.at_ms)
        .min(0.0);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(set.caption.clone(), ("sans-serif", 14))
        .x_label_area_size(32)
        .y_label_area_size(52)
        .build_cartesian_2d(start_ms..end_ms, low..high)
        .map_err(reason)?;
    chart
        .configure_mesh()
        .x_desc("ms since the first step")
        .y_desc(unit)
        .draw()
        .map_err(reason)?;
    let set_points = set.samples.iter().filter(|_| set.has_set_points);
    let set_points = set_points.map(|sample| (sample.at_ms, f64::from(sample.set_point)));
    chart
        .draw_series(LineSeries::new(set_points, SET_POINT.stroke_width(1)))
        .map_err(reason)?;
    let positions = set.samples.iter();
    let positions = positions.map(|sample| (sample.at_ms, f64::from(sample.actual)));
    chart
        .draw_series(LineSeries::new(positions, POSITION.stroke_width(2)))
        .map_err(reason)?;
    Ok(())
}

fn reason(error: impl Display) -> String {
    error.to_string()
}
