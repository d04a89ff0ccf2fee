//! Load of every cycle, and below it the events of the bus and of each axis.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{
    Area, COLUMNS, Drawn, TIME_LABELS, WIDTH, at_s, font, mesh, reason, seconds, time_chart,
};
use crate::sim::recording::{Kind, Recording, Sample};
use crate::sim::report::palette;
use crate::sim::report::thin::thin;

const LOAD_HEIGHT: u32 = 180;
const ROW_HEIGHT: u32 = 24;

/// Load in percent above, events below, over the same time.
pub(in crate::sim::report) fn bus(recording: &Recording) -> Drawn<String> {
    let rows = rows(recording);
    let events_height = ROW_HEIGHT * rows.len() as u32 + TIME_LABELS + 12;
    let mut text = String::new();
    {
        let size = (WIDTH, LOAD_HEIGHT + events_height);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let (upper, lower) = root.split_vertically(LOAD_HEIGHT);
        draw_load(&upper, recording)?;
        draw_events(&lower, recording, &rows)?;
        root.present().map_err(reason)?;
    }
    Ok(text)
}

fn draw_load(area: &Area<'_>, recording: &Recording) -> Drawn<()> {
    let load = |sample: &Sample| (seconds(sample), 100.0 * sample.load);
    let all = recording.samples.iter().map(load);
    let late = recording.samples.iter().filter(|sample| sample.is_late);
    let mut chart = time_chart(area, recording, 0.0..100.0, 0)?;
    mesh(&mut chart, "bus load, %", "", 6)?;
    chart
        .draw_series(LineSeries::new(
            thin(all, recording.end_s(), COLUMNS),
            palette::BUS,
        ))
        .map_err(reason)?;
    chart
        .draw_series(late.map(|sample| Circle::new(load(sample), 3, palette::FAULT.filled())))
        .map_err(reason)?;
    Ok(())
}

/// The whole bus, then each axis.
fn rows(recording: &Recording) -> Vec<Option<usize>> {
    let axes = (0..recording.drives.len()).map(Some);
    core::iter::once(None).chain(axes).collect()
}

/// A dot for each event in the row of its axis; the first row is the highest.
fn draw_events(area: &Area<'_>, recording: &Recording, rows: &[Option<usize>]) -> Drawn<()> {
    let middle = move |row: usize| (rows.len() - row) as f64 - 0.5;
    let mut chart = time_chart(area, recording, 0.0..rows.len() as f64, TIME_LABELS)?;
    mesh(&mut chart, "", "time, s", 0)?;
    let style = font().pos(Pos::new(HPos::Right, VPos::Center));
    let (left, top) = area.get_base_pixel();
    for (row, of) in rows.iter().enumerate() {
        let name = of.map_or("bus".to_owned(), |axis| recording.name(axis));
        let (x, y) = chart.backend_coord(&(0.0, middle(row)));
        area.draw_text(&name, &style, (x - left - 8, y - top))
            .map_err(reason)?;
    }
    let end_s = recording.end_s();
    // What matters most is drawn last, over the others, and is small enough to leave them in sight.
    let kinds = [
        (Kind::Phase, palette::STATE, 3),
        (Kind::State, palette::STATE, 3),
        (Kind::Cause, palette::CAUSE, 7),
        (Kind::Notice, palette::NOTICE, 3),
        (Kind::Fault, palette::FAULT, 4),
    ];
    let dots = kinds.into_iter().flat_map(|(kind, color, size)| {
        let of_kind = recording.happenings.iter();
        of_kind
            .filter(move |happening| happening.kind == kind)
            .filter_map(move |happening| {
                let row = rows.iter().position(|row| *row == happening.axis)?;
                let place = (at_s(happening).min(end_s), middle(row));
                Some(Circle::new(place, size, color.filled()))
            })
    });
    chart.draw_series(dots).map_err(reason)?;
    Ok(())
}
