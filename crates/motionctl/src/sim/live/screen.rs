//! The picture in the terminal: axes, bus load, events, keys.

use dyn_can::DriveId;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Cell, Paragraph, Row, Sparkline, Table, Wrap};

use super::keys::Panel;
use crate::set_points::Speed;
use crate::sim::recording::{AxisSample, Happening, Kind, Recording};

/// Virtual time that the picture of the load covers.
const LOAD_WINDOW_US: u64 = 2_000_000;
const KEYS: &str =
    " up/down  a alarm  p plug  space pause  + - 1 speed  s stop  f [ ] time  q quit";

/// Name, unit and width of each column of the axes.
const COLUMNS: [(&str, &str, Constraint); 10] = [
    ("axis", "", Constraint::Length(4)),
    ("drive", "", Constraint::Length(5)),
    ("state", "", Constraint::Min(12)),
    ("target", "counts", Constraint::Length(10)),
    ("sent", "counts", Constraint::Length(10)),
    ("motor", "counts", Constraint::Length(10)),
    ("error", "counts", Constraint::Length(7)),
    ("backlog", "counts", Constraint::Length(7)),
    ("status", "age ms", Constraint::Length(6)),
    ("position", "age ms", Constraint::Length(8)),
];
const STATE: usize = 2;
const SENT: usize = 4;
/// What a narrower terminal has no room for is left out: sent is target less backlog.
const WIDE: u16 = 100;

/// Everything that is drawn.
pub(super) struct Screen<'a> {
    pub(super) recording: &'a Recording,
    /// State of each axis in words.
    pub(super) states: &'a [String],
    pub(super) panel: &'a Panel,
    /// Length of the motion.
    pub(super) motion_us: u64,
    /// The simulation cannot keep up with real time.
    pub(super) is_behind: bool,
    /// How fast the motion goes.
    pub(super) speed: Option<Speed>,
    /// The result, once there is one.
    pub(super) verdict: Option<&'a str>,
}

impl Screen<'_> {
    pub(super) fn draw(&self, frame: &mut Frame<'_>) {
        let axes_height = self.recording.drives.len() as u16 + 4;
        let verdict_height = if self.verdict.is_some() { 2 } else { 0 };
        let [head, verdict, axes, load, events, keys] = Layout::vertical([
            Constraint::Length(1),
            Constraint::Length(verdict_height),
            Constraint::Max(axes_height),
            Constraint::Length(6),
            Constraint::Min(4),
            Constraint::Length(1),
        ])
        .areas(frame.area());
        frame.render_widget(self.head(), head);
        frame.render_widget(self.verdict(), verdict);
        frame.render_widget(self.axes(axes.width), axes);
        self.draw_load(frame, load);
        frame.render_widget(self.events(events), events);
        frame.render_widget(Paragraph::new(KEYS).reversed(), keys);
    }

    fn head(&self) -> Paragraph<'_> {
        let status = if self.panel.is_frozen() {
            "FROZEN"
        } else if self.speed.is_some_and(|speed| speed.is_paused) {
            "PAUSED"
        } else if self.is_behind {
            "too slow for real time"
        } else {
            ""
        };
        let time = format!(
            " {:8.3} s   motion {:.1} s at {:.0} %   time {}x   ",
            self.recording.end_s(),
            self.motion_us as f64 * 1e-6,
            self.speed.map_or(100.0, |speed| speed.actual_percent),
            self.panel.speed()
        );
        let status = Span::styled(status, Style::new().fg(Color::Yellow).bold());
        Paragraph::new(Line::from(vec![Span::raw(time), status]))
    }

    fn verdict(&self) -> Paragraph<'_> {
        let verdict = self.verdict.unwrap_or_default();
        let color = if verdict.contains("BROKEN") {
            Color::Red
        } else {
            Color::Green
        };
        Paragraph::new(verdict)
            .style(Style::new().fg(color).bold())
            .wrap(Wrap { trim: true })
    }

    fn axes(&self, width: u16) -> Table<'_> {
        let shown = |column: &usize| width >= WIDE || *column != SENT;
        let columns: Vec<usize> = (0..COLUMNS.len()).filter(shown).collect();
        let of_axes = self
            .recording
            .samples
            .last()
            .map(|sample| sample.axes.as_slice());
        let rows = of_axes
            .unwrap_or_default()
            .iter()
            .enumerate()
            .map(|(axis, sample)| {
                let mut cells = self.cells(axis, sample);
                let row = Row::new(
                    columns
                        .iter()
                        .map(|&column| core::mem::take(&mut cells[column])),
                );
                if axis == self.panel.selected() {
                    row.add_modifier(Modifier::REVERSED)
                } else {
                    row
                }
            });
        let head = columns.iter().map(|&column| {
            let (name, unit, _) = COLUMNS[column];
            let text = format!("{name}\n{unit}");
            if column == STATE {
                Cell::from(text)
            } else {
                right(&text)
            }
        });
        Table::new(rows, columns.iter().map(|&column| COLUMNS[column].2))
            .header(Row::new(head).height(2).bold())
            .block(Block::bordered().title(" axes "))
    }

    fn cells(&self, axis: usize, sample: &AxisSample) -> [Cell<'_>; 10] {
        let age = |age: Option<u32>| {
            age.map_or("-".to_owned(), |us| format!("{:.1}", f64::from(us) * 1e-3))
        };
        let drive = self
            .recording
            .drives
            .get(axis)
            .map_or(0, |drive| drive.get());
        [
            right(&axis.to_string()),
            right(&drive.to_string()),
            self.state(axis),
            right(&sample.target.to_string()),
            right(&sample.sent.to_string()),
            right(&sample.drive.to_string()),
            right(&sample.error().to_string()),
            right(&sample.backlog.to_string()),
            right(&age(sample.status_age_us)),
            right(&age(sample.position_age_us)),
        ]
    }

    fn state(&self, axis: usize) -> Cell<'_> {
        let state = self.states.get(axis).map_or("", String::as_str);
        if self.panel.is_unplugged(axis) {
            return Cell::from(format!("off the bus, {state}")).yellow();
        }
        let color = match state {
            "faulted" => Color::Red,
            "streaming" => Color::Green,
            _ => Color::Reset,
        };
        Cell::from(state).style(Style::new().fg(color))
    }

    fn draw_load(&self, frame: &mut Frame<'_>, area: Rect) {
        let columns = usize::from(area.width.saturating_sub(2)).max(1);
        let loads = self.loads(columns);
        let late = self
            .recording
            .samples
            .iter()
            .filter(|sample| sample.is_late)
            .count();
        let title = format!(
            " bus load {:.0} %; below the last {} s, full height 100 %; {late} late cycles ",
            self.recording
                .samples
                .last()
                .map_or(0.0, |sample| 100.0 * sample.load),
            LOAD_WINDOW_US / 1_000_000
        );
        let spark = Sparkline::default()
            .block(Block::bordered().title(title))
            .data(loads)
            .max(100)
            .style(Style::new().fg(Color::Cyan));
        frame.render_widget(spark, area);
    }

    /// Largest load in percent of each part of the window, the newest last.
    fn loads(&self, columns: usize) -> Vec<u64> {
        let end_us = self
            .recording
            .samples
            .last()
            .map_or(0, |sample| sample.at_us);
        let from_us = end_us.saturating_sub(LOAD_WINDOW_US);
        let mut loads = vec![0; columns];
        let recent = self.recording.samples.iter().rev();
        for sample in recent.take_while(|sample| sample.at_us > from_us) {
            let place = (sample.at_us - from_us - 1) * columns as u64 / LOAD_WINDOW_US;
            if let Some(load) = loads.get_mut(place as usize) {
                *load = (*load).max((100.0 * sample.load).round() as u64);
            }
        }
        loads
    }

    fn events(&self, area: Rect) -> Paragraph<'_> {
        let room = usize::from(area.height.saturating_sub(2));
        let newest = self.recording.happenings.len().saturating_sub(room);
        let lines: Vec<Line<'_>> = self.recording.happenings[newest..]
            .iter()
            .map(|happening| self.event_line(happening))
            .collect();
        let selected = self.recording.drives.get(self.panel.selected());
        let title = format!(
            " events;  keys a and p are for {} ",
            selected.map_or_else(String::new, |drive| name(*drive))
        );
        Paragraph::new(lines).block(Block::bordered().title(title))
    }

    fn event_line(&self, happening: &Happening) -> Line<'_> {
        let color = match happening.kind {
            Kind::Cause => Color::Yellow,
            Kind::Fault => Color::Red,
            Kind::Notice => Color::Cyan,
            Kind::State | Kind::Phase => Color::Reset,
        };
        let axis = happening
            .axis
            .map_or("bus".to_owned(), |axis| self.recording.name(axis));
        let text = format!(
            "{:9.3} s  {axis:8} {happening}",
            happening.at_us as f64 * 1e-6,
        );
        Line::styled(text, Style::new().fg(color))
    }
}

fn right(text: &str) -> Cell<'static> {
    let lines: Vec<Line<'static>> = text
        .lines()
        .map(|line| Line::from(line.to_owned()).right_aligned())
        .collect();
    Cell::from(lines)
}

/// The drives as the keys name them.
fn name(drive: DriveId) -> String {
    format!("drive {drive}")
}

#[cfg(test)]
mod tests {
    use super::super::keys::Key;
    use super::*;
    use crate::sim::recording::Sample;
    use drive_sim::{BitRate, Bus, ControllerConfig};
    use dyn_can::DriveId;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn recording() -> Recording {
        let node = Bus::new(BitRate::Kbit1000).add_node(ControllerConfig::device());
        let mut recording = Recording::new(DriveId::all().take(2).collect(), node, 1_000, 1_000);
        let axis = |target| AxisSample {
            target,
            sent: target - 10,
            drive: i64::from(target) - 25,
            backlog: 10,
            status_age_us: Some(12_300),
            position_age_us: None,
        };
        recording.samples.push(Sample {
            at_us: 1_500_000,
            load: 0.375,
            is_late: true,
            axes: vec![axis(123_456), axis(-7)],
        });
        recording.happened(1_400_000, Some(1), Kind::Fault, "the drive does not answer");
        recording
    }

    fn drawn(panel: &Panel, verdict: Option<&str>, width: u16) -> String {
        let recording = recording();
        let states = ["streaming".to_owned(), "faulted".to_owned()];
        let screen = Screen {
            recording: &recording,
            states: &states,
            panel,
            motion_us: 6_000_000,
            is_behind: false,
            speed: None,
            verdict,
        };
        let mut terminal = Terminal::new(TestBackend::new(width, 24)).unwrap();
        terminal.draw(|frame| screen.draw(frame)).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn axes_load_events_and_keys_are_there() {
        let mut panel = Panel::new(DriveId::all().take(2).collect());
        panel.press(Key::Down);
        panel.press(Key::Plug);
        let text = drawn(&panel, None, 110);
        for wanted in [
            "1.500 s   motion 6.0 s at 100 %   time 1x",
            "123456",
            "off the bus, faulted",
            "12.3",
            "bus load 38 %",
            "1 late cycles",
            "1.400 s  drive 2  the drive does not answer",
            "keys a and p are for drive 2",
            "p plug",
        ] {
            assert!(text.contains(wanted), "{wanted} in\n{text}");
        }
    }

    #[test]
    fn the_verdict_is_shown() {
        let panel = Panel::new(DriveId::all().take(2).collect());
        assert!(drawn(&panel, Some("Every promise kept"), 110).contains("Every promise kept"));
    }

    #[test]
    fn eighty_columns_are_enough() {
        let panel = Panel::new(DriveId::all().take(2).collect());
        let text = drawn(&panel, None, 80);
        for wanted in ["123456", "backlog", "position", "q quit", "age ms"] {
            assert!(text.contains(wanted), "{wanted} in\n{text}");
        }
        assert!(!text.contains(" sent"), "there is no room for it");
    }
}
