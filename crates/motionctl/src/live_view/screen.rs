//! The picture in the terminal: axes, bus load, events, keys. Everything has room in 80 columns and 24 lines up to 14 axes.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders, Cell, Paragraph, Row, Sparkline, Table, Wrap};

use crate::recording::{AxisSample, COUNTS_PER_RPM, Happening, Kind, Quantity, Recording};

/// Time that the picture of the load covers.
pub(crate) const LOAD_WINDOW_US: u64 = 2_000_000;

/// Least and most letters of a name.
const NAME_WIDTH: u16 = 10;
const WIDE_NAME: u16 = 18;

/// Name, unit and width of each column of the axes.
const COLUMNS: [(&str, &str, Constraint); 10] = [
    ("axis", "", Constraint::Length(NAME_WIDTH)),
    ("drive", "", Constraint::Length(5)),
    ("state", "", Constraint::Min(11)),
    ("target", "counts", Constraint::Length(9)),
    ("sent", "counts", Constraint::Length(9)),
    ("motor", "counts", Constraint::Length(9)),
    ("error", "counts", Constraint::Length(7)),
    ("backlog", "counts", Constraint::Length(7)),
    ("status", "age ms", Constraint::Length(6)),
    ("position", "age ms", Constraint::Length(8)),
];
const NAME: usize = 0;
const STATE: usize = 2;
const SENT: usize = 4;
/// What a narrower terminal has no room for is left out: sent is target less backlog.
const WIDE: u16 = 100;
/// Lines of the events where there is little room.
const LEAST_EVENTS: u16 = 3;
/// Lines that the roomy picture needs besides its axes: border and two lines of names, load, events.
const ROOMY: u16 = 3 + 6 + 4;

/// Everything that is drawn.
pub(crate) struct Screen<'a> {
    pub(crate) recording: &'a Recording,
    /// The axis that the keys are for.
    pub(crate) selected: usize,
    /// Axes that somebody took off the bus.
    pub(crate) off_the_bus: &'a [bool],
    /// What is said behind the time.
    pub(crate) head: &'a str,
    /// What the user should notice.
    pub(crate) status: &'a str,
    pub(crate) keys: &'a str,
    /// Title of the events.
    pub(crate) events_title: &'a str,
    /// Messages of the tool, the newest last.
    pub(crate) messages: &'a [String],
    /// The result, once there is one, and whether it is good.
    pub(crate) verdict: Option<(&'a str, bool)>,
}

/// How the lines are shared out.
struct Lines {
    axes: u16,
    load: u16,
    is_roomy: bool,
    /// The first axis that is shown, and how many.
    first: usize,
    shown: usize,
}

impl Screen<'_> {
    pub(crate) fn draw(&self, frame: &mut Frame<'_>) {
        let area = frame.area();
        let keys = key_lines(self.keys, area.width);
        let fixed = [
            Constraint::Length(1),
            Constraint::Length(self.verdict_height(area.width)),
            Constraint::Length(keys.len() as u16),
        ];
        let [head, verdict, rest, keys_area] =
            Layout::vertical([fixed[0], fixed[1], Constraint::Min(0), fixed[2]]).areas(area);
        let lines = self.lines(rest.height);
        let [axes, load, events] = Layout::vertical([
            Constraint::Length(lines.axes),
            Constraint::Length(lines.load),
            Constraint::Min(0),
        ])
        .areas(rest);
        frame.render_widget(self.head(&lines), head);
        frame.render_widget(self.verdict(), verdict);
        frame.render_widget(self.axes(axes.width, &lines), axes);
        self.draw_load(frame, load, lines.is_roomy);
        frame.render_widget(self.events(events), events);
        frame.render_widget(Paragraph::new(keys).reversed(), keys_area);
    }

    fn lines(&self, height: u16) -> Lines {
        let axes = self.recording.about.axes.len();
        let all = u16::try_from(axes).unwrap_or(u16::MAX);
        if all.saturating_add(ROOMY) <= height {
            return Lines {
                axes: all + 3,
                load: 6,
                is_roomy: true,
                first: 0,
                shown: axes,
            };
        }
        // One line of names, one of load.
        let room = height.saturating_sub(2 + LEAST_EVENTS).max(1);
        let shown = usize::from(room).min(axes);
        // Around the selected one when there is no room for all.
        let first = self
            .selected
            .saturating_sub(shown / 2)
            .min(axes.saturating_sub(shown));
        Lines {
            axes: shown as u16 + 1,
            load: 1,
            is_roomy: false,
            first,
            shown,
        }
    }

    fn head(&self, lines: &Lines) -> Paragraph<'_> {
        let axes = self.recording.about.axes.len();
        let part = if lines.shown < axes {
            format!(
                "axes {} to {} of {axes}   ",
                lines.first + 1,
                lines.first + lines.shown
            )
        } else {
            String::new()
        };
        let time = format!(" {:8.3} s   {}   {part}", self.recording.end_s(), self.head);
        let status = Span::styled(self.status, Style::new().fg(Color::Yellow).bold());
        Paragraph::new(Line::from(vec![Span::raw(time), status]))
    }

    fn verdict_height(&self, width: u16) -> u16 {
        let Some((verdict, _)) = self.verdict else {
            return 0;
        };
        let lines = verdict.len().div_ceil(usize::from(width.max(1)));
        u16::try_from(lines.clamp(1, 3)).unwrap_or(1)
    }

    fn verdict(&self) -> Paragraph<'_> {
        let (verdict, is_good) = self.verdict.unwrap_or_default();
        let color = if is_good { Color::Green } else { Color::Red };
        Paragraph::new(verdict)
            .style(Style::new().fg(color).bold())
            .wrap(Wrap { trim: true })
    }

    fn axes(&self, width: u16, lines: &Lines) -> Table<'_> {
        let shown = |column: &usize| width >= WIDE || *column != SENT;
        let columns: Vec<usize> = (0..COLUMNS.len()).filter(shown).collect();
        let latest = self.recording.latest.as_ref();
        let of_axes = latest.map_or(&[][..], |sample| sample.axes.as_slice());
        let places = lines.first..lines.first + lines.shown;
        let rows = places.filter_map(|axis| {
            let mut cells = self.cells(axis, of_axes.get(axis)?, name_width(width));
            let cells = columns
                .iter()
                .map(|&column| core::mem::take(&mut cells[column]));
            let row = Row::new(cells);
            Some(if axis == self.selected {
                row.add_modifier(Modifier::REVERSED)
            } else {
                row
            })
        });
        let is_speed = self.recording.about.quantity == Quantity::Speed;
        let head = columns.iter().map(|&column| {
            let (name, unit) = match (COLUMNS[column].0, COLUMNS[column].1) {
                ("drive", unit) if is_speed => ("node", unit),
                ("motor", _) if is_speed => ("wheel", "r/min"),
                (name, "counts") if is_speed => (name, "r/min"),
                other => other,
            };
            let text = if lines.is_roomy {
                format!("{name}\n{unit}")
            } else {
                name.to_owned()
            };
            if column == STATE || column == NAME {
                Cell::from(text)
            } else {
                right(&text)
            }
        });
        let widths = columns.iter().map(|&column| match column {
            NAME => Constraint::Length(name_width(width)),
            _ => COLUMNS[column].2,
        });
        let table = Table::new(rows, widths);
        if lines.is_roomy {
            table
                .header(Row::new(head).height(2).bold())
                .block(Block::new().borders(Borders::TOP).title(" axes "))
        } else {
            table.header(Row::new(head).bold().underlined())
        }
    }

    fn cells(&self, axis: usize, sample: &AxisSample, name_width: u16) -> [Cell<'_>; 10] {
        let age = |age: Option<u32>| {
            age.map_or("-".to_owned(), |us| format!("{:.1}", f64::from(us) * 1e-3))
        };
        let about = self.recording.about.axes.get(axis);
        let is_speed = self.recording.about.quantity == Quantity::Speed;
        let value = |counts: i64| {
            if is_speed {
                format!("{:.1}", counts as f64 / COUNTS_PER_RPM)
            } else {
                counts.to_string()
            }
        };
        let counts = |counts: Option<i64>| counts.map_or("-".to_owned(), value);
        let known = self.recording.known_positions.get(axis).copied().flatten();
        [
            Cell::from(about.map_or(String::new(), |about| cut(&about.name, name_width))),
            right(&about.map_or(String::new(), |about| about.drive.to_string())),
            self.state(axis, sample),
            right(&value(sample.target.into())),
            right(&value(sample.sent.into())),
            right(&counts(known.map(|(position, _)| position))),
            right(&counts(known.map(|(_, error)| error))),
            right(&value(sample.backlog.into())),
            right(&age(sample.status_age_us)),
            right(&age(sample.position_age_us)),
        ]
    }

    fn state(&self, axis: usize, sample: &AxisSample) -> Cell<'_> {
        let state = sample
            .state
            .map_or(String::new(), |state| state.to_string());
        if self.off_the_bus.get(axis).is_some_and(|is_off| *is_off) {
            return Cell::from(format!("off the bus, {state}")).yellow();
        }
        let color = match state.as_str() {
            "faulted" => Color::Red,
            "streaming" => Color::Green,
            _ => Color::Reset,
        };
        Cell::from(state).style(Style::new().fg(color))
    }

    fn draw_load(&self, frame: &mut Frame<'_>, area: Rect, is_roomy: bool) {
        let latest = self.recording.latest.as_ref();
        let now = format!(
            " bus load {:.0} %; {} late cycles; the last {} s ",
            latest.map_or(0.0, |sample| 100.0 * sample.load),
            self.recording.late_cycles,
            LOAD_WINDOW_US / 1_000_000
        );
        let style = Style::new().fg(Color::Cyan);
        let (area, block) = if is_roomy {
            let title = format!("{now}below, full height 100 % ");
            (area, Some(Block::new().borders(Borders::TOP).title(title)))
        } else {
            let width = now.len() as u16;
            let [text, spark] =
                Layout::horizontal([Constraint::Length(width), Constraint::Min(0)]).areas(area);
            frame.render_widget(Paragraph::new(now), text);
            (spark, None)
        };
        let loads = self.loads(usize::from(area.width).max(1));
        let spark = Sparkline::default().data(loads).max(100).style(style);
        match block {
            Some(block) => frame.render_widget(spark.block(block), area),
            None => frame.render_widget(spark, area),
        }
    }

    /// Largest load in percent of each part of the window, the newest last.
    fn loads(&self, columns: usize) -> Vec<u64> {
        let latest = self.recording.latest.as_ref();
        let end_us = latest.map_or(0, |sample| sample.at_us);
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

    /// The newest events, below them the messages of the tool.
    fn events(&self, area: Rect) -> Paragraph<'_> {
        let room = usize::from(area.height.saturating_sub(1));
        let messages = self.messages.iter().map(|message| {
            let line = message.lines().next().unwrap_or_default();
            Line::styled(format!(" {line}"), Style::new().bold())
        });
        let events = self.recording.happenings.iter();
        let events = events.map(|happening| self.event_line(happening));
        let all: Vec<Line<'_>> = events.chain(messages).collect();
        let newest = all.len().saturating_sub(room);
        let title = self.events_title;
        Paragraph::new(all[newest..].to_vec())
            .block(Block::new().borders(Borders::TOP).title(title))
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

/// The keys in as many lines as they need: two blanks stand between two of them.
fn key_lines(keys: &str, width: u16) -> Vec<Line<'_>> {
    let width = usize::from(width);
    let mut lines: Vec<String> = vec![String::new()];
    for key in keys.split("  ") {
        let is_full = lines
            .last()
            .is_some_and(|line| !line.is_empty() && line.len() + 2 + key.len() + 1 > width);
        if is_full {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if line.is_empty() { " " } else { "  " });
            line.push_str(key);
        }
    }
    lines.into_iter().map(Line::from).collect()
}

/// What the columns need not goes to the names.
fn name_width(terminal: u16) -> u16 {
    let needed = if terminal >= WIDE { 94 } else { 80 };
    let room = NAME_WIDTH + terminal.saturating_sub(needed);
    room.min(WIDE_NAME)
}

/// A name that is too long says that it goes on.
fn cut(name: &str, width: u16) -> String {
    let width = usize::from(width);
    if name.chars().count() <= width {
        return name.to_owned();
    }
    let start = name.chars().take(width.saturating_sub(1));
    start.chain(['…']).collect()
}

fn right(text: &str) -> Cell<'static> {
    let lines: Vec<Line<'static>> = text
        .lines()
        .map(|line| Line::from(line.to_owned()).right_aligned())
        .collect();
    Cell::from(lines)
}

#[cfg(test)]
mod tests;
