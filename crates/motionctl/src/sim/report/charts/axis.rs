//! Panels of one axis above a common time axis.

use core::ops::Range;

use plotters::prelude::*;

use super::{Area, COLUMNS, Drawn, TIME_LABELS, WIDTH, at_s, mesh, reason, seconds, time_chart};
use crate::sim::recording::{AxisSample, Kind, Recording};
use crate::sim::report::palette;
use crate::sim::report::thin::{peaks, thin};

/// Room in pixels for one label of a value.
const LABEL_HEIGHT: u32 = 32;

/// Columns of the poll ages: wide enough for several polls in a run of seconds.
const AGE_COLUMNS: u32 = COLUMNS / 6;

/// One curve of a panel.
struct Curve {
    points: Vec<(f64, f64)>,
    color: RGBColor,
    width: u32,
}

/// One panel above the common time axis.
struct Panel {
    title: &'static str,
    height: u32,
    curves: Vec<Curve>,
    /// The least that the panel shows.
    at_least: Range<f64>,
}

/// One axis of a recording.
struct OfAxis<'a> {
    recording: &'a Recording,
    axis: usize,
}

impl OfAxis<'_> {
    fn curve(
        &self,
        color: RGBColor,
        width: u32,
        value: impl Fn(&AxisSample) -> Option<f64>,
    ) -> Curve {
        Curve {
            points: thin(self.values(value), self.recording.end_s(), COLUMNS),
            color,
            width,
        }
    }

    /// The oldest of a while in milliseconds, while polls run: from the start of the motion on.
    fn age(&self, color: RGBColor, age_us: impl Fn(&AxisSample) -> Option<u32>) -> Curve {
        let start_s = self.recording.motion_start_us.unwrap_or(0) as f64 * 1e-6;
        let ages = self
            .values(|axis| Some(f64::from(age_us(axis)?) * 1e-3))
            .filter(|(at_s, _)| *at_s >= start_s);
        Curve {
            points: peaks(ages, self.recording.end_s(), AGE_COLUMNS),
            color,
            width: 2,
        }
    }

    fn values(
        &self,
        value: impl Fn(&AxisSample) -> Option<f64>,
    ) -> impl Iterator<Item = (f64, f64)> {
        self.recording.samples.iter().filter_map(move |sample| {
            let of_axis = sample.axes.get(self.axis)?;
            Some((seconds(sample), value(of_axis)?))
        })
    }

    fn panels(&self) -> [Panel; 4] {
        [
            Panel {
                title: "position, counts",
                height: 230,
                // Where all three agree each is seen beside the next.
                curves: vec![
                    self.curve(palette::TARGET, 9, |axis| Some(f64::from(axis.target))),
                    self.curve(palette::SENT, 4, |axis| Some(f64::from(axis.sent))),
                    self.curve(palette::DRIVE, 2, |axis| Some(axis.drive as f64)),
                ],
                at_least: -1.0..1.0,
            },
            Panel {
                title: "error, counts",
                height: 130,
                curves: vec![self.curve(palette::ERROR, 1, |axis| Some(axis.error() as f64))],
                at_least: -10.0..10.0,
            },
            Panel {
                title: "backlog, counts",
                height: 125,
                curves: vec![self.curve(palette::BACKLOG, 1, |axis| Some(f64::from(axis.backlog)))],
                at_least: -10.0..10.0,
            },
            Panel {
                title: "oldest poll, ms",
                height: 120,
                curves: vec![
                    self.age(palette::STATUS_AGE, |axis| axis.status_age_us),
                    self.age(palette::POSITION_AGE, |axis| axis.position_age_us),
                ],
                at_least: 0.0..1.0,
            },
        ]
    }

    /// What is marked in every panel; what matters most is drawn last, over the others.
    fn marks(&self) -> impl Iterator<Item = (f64, RGBColor)> {
        let kinds = [
            (Kind::Phase, palette::STATE),
            (Kind::Cause, palette::CAUSE),
            (Kind::Fault, palette::FAULT),
        ];
        kinds.into_iter().flat_map(move |(kind, color)| {
            let of_kind = self.recording.happenings.iter().filter(move |happening| {
                happening.kind == kind && happening.axis.is_none_or(|axis| axis == self.axis)
            });
            of_kind.map(move |happening| (at_s(happening), color))
        })
    }

    fn draw(&self, area: &Area<'_>, panel: &Panel, label_height: u32) -> Drawn<()> {
        let range = panel.range();
        let mut chart = time_chart(area, self.recording, range.clone(), label_height)?;
        let time = if label_height > 0 { "time, s" } else { "" };
        let labels = (panel.height / LABEL_HEIGHT) as usize;
        mesh(&mut chart, panel.title, time, labels)?;
        for (at_s, color) in self.marks() {
            let line = [(at_s, range.start), (at_s, range.end)];
            chart
                .draw_series(LineSeries::new(line, color.stroke_width(1)))
                .map_err(reason)?;
        }
        for curve in &panel.curves {
            let style = curve.color.stroke_width(curve.width);
            chart
                .draw_series(LineSeries::new(curve.points.iter().copied(), style))
                .map_err(reason)?;
        }
        Ok(())
    }
}

impl Panel {
    /// All values with some room, and at least what the panel wants.
    fn range(&self) -> Range<f64> {
        let values = self
            .curves
            .iter()
            .flat_map(|curve| curve.points.iter().map(|point| point.1));
        let start = (self.at_least.start, self.at_least.end);
        let (least, most) = values.fold(start, |(least, most), value| {
            (least.min(value), most.max(value))
        });
        let room = 0.06 * (most - least);
        let below = if least < 0.0 { room } else { 0.0 };
        least - below..most + room
    }
}

/// Target, sent and drive; error; backlog; ages of the readings of one axis.
pub(in crate::sim::report) fn axis(recording: &Recording, axis: usize) -> Drawn<String> {
    let of_axis = OfAxis { recording, axis };
    let panels = of_axis.panels();
    let height: u32 = panels.iter().map(|panel| panel.height).sum();
    let mut text = String::new();
    {
        let backend = SVGBackend::with_string(&mut text, (WIDTH, height + TIME_LABELS));
        let root = backend.into_drawing_area();
        let mut rest = root.clone();
        for (number, panel) in panels.iter().enumerate() {
            let is_lowest = number + 1 == panels.len();
            let label_height = if is_lowest { TIME_LABELS } else { 0 };
            let (area, below) = rest.split_vertically(panel.height + label_height);
            of_axis.draw(&area, panel, label_height)?;
            rest = below;
        }
        root.present().map_err(reason)?;
    }
    Ok(text)
}
