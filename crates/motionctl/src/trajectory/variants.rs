//! One motion written in many ways: whatever is read is that motion, and whatever is refused says where and what to do.

use proptest::prelude::*;
use proptest::sample::select;

use super::columns::ColumnChoice;
use super::table::{Reading, Table};
use super::unit::{TimeUnit, Unit};
use super::{TrajectoryError, resolve};

/// A motion, and how a file has it.
#[derive(Debug, Clone)]
struct Written {
    /// Thousandths of a second.
    times_ms: Vec<u32>,
    /// Thousandths of a degree, axis by axis.
    angles_mdeg: Vec<Vec<i32>>,
    style: Style,
}

#[derive(Debug, Clone)]
struct Style {
    time_name: (&'static str, TimeUnit),
    axis_names: Vec<&'static str>,
    unit: Unit,
    /// Columns that are neither time nor position.
    extras: Vec<(&'static str, &'static str)>,
    /// Order of the columns.
    order: Vec<usize>,
    separator: &'static str,
    line_end: &'static str,
    mark: bool,
    comment: bool,
    exponent: bool,
    decimal_comma: bool,
    epoch: bool,
}

const TIME_NAMES: [(&str, TimeUnit); 18] = [
    ("t", TimeUnit::S),
    ("time", TimeUnit::S),
    ("Time", TimeUnit::S),
    ("time_s", TimeUnit::S),
    ("t[s]", TimeUnit::S),
    ("timestamp", TimeUnit::S),
    ("time_from_start", TimeUnit::S),
    ("Zeit", TimeUnit::S),
    ("seconds", TimeUnit::S),
    ("time_ms", TimeUnit::Ms),
    ("timeMs", TimeUnit::Ms),
    ("t(us)", TimeUnit::Us),
    ("stamp_ns", TimeUnit::Ns),
    ("t/ns", TimeUnit::Ns),
    ("time_mS", TimeUnit::Ms),
    ("t_µS", TimeUnit::Us),
    ("Zeit_Millisekunden", TimeUnit::Ms),
    ("stamp_nanosec", TimeUnit::Ns),
];

/// Names that say nothing, and names that say that they are positions.
const AXIS_NAMES: [[&str; 4]; 6] = [
    ["x", "y", "z", "u"],
    ["joint1", "joint2", "joint3", "joint4"],
    ["shoulder", "elbow", "lift", "gripper"],
    ["pos_1", "pos_2", "pos_3", "pos_4"],
    ["q1", "q2", "q3", "q4"],
    ["position[0]", "position[1]", "position[2]", "position[3]"],
];

const EXTRAS: [(&str, &str); 10] = [
    ("velocity", "99"),
    ("qd1", "-3.5"),
    ("acc", "7"),
    ("effort[0]", "0.1"),
    ("status", "ok"),
    ("index", "12"),
    ("left_rpm", "3000"),
    ("x_error", "1"),
    ("temperature", "41"),
    ("current", ""),
];

/// Names of columns that hold anything but an axis, and that no list of words knows all of.
const STRANGERS: [&str; 24] = [
    "F",
    "iq",
    "freq",
    "duty",
    "confidence",
    "timestep",
    "dwell",
    "crc",
    "x_filtered",
    "x_max",
    "joint1_old",
    "a_x",
    "qw",
    "pos_raw",
    "x_yd",
    "x_kcounts",
    "q1_mDeg",
    "Kommentar",
    "lat",
    "gripper_open",
    "zone",
    "override",
    "L\u{fffd}nge",
    "ω",
];

fn styles(axes: usize) -> impl Strategy<Value = Style> {
    let extras = prop::sample::subsequence(&EXTRAS[..], 0..4);
    let flags = (
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
        any::<bool>(),
    );
    let looks = (
        select(&[",", ";", "\t", " ", ", ", " ; ", "  "][..]),
        select(&["\n", "\r\n", "\r"][..]),
        select(&[Unit::Degrees, Unit::Radians, Unit::Turns][..]),
    );
    (
        select(&TIME_NAMES[..]),
        select(&AXIS_NAMES[..]),
        extras,
        looks,
        flags,
    )
        .prop_flat_map(
            move |(time_name, names, mut extras, (separator, line_end, unit), flags)| {
                let (mark, comment, exponent, decimal_comma, epoch) = flags;
                if separator.trim().is_empty() && separator != "\t" {
                    // Blanks cannot keep the place of an empty field.
                    extras.retain(|(_, value)| !value.is_empty());
                }
                let columns: Vec<usize> = (0..=axes + extras.len()).collect();
                let style = Style {
                    time_name,
                    axis_names: names[..axes].to_vec(),
                    unit,
                    extras,
                    order: Vec::new(),
                    separator,
                    line_end,
                    mark,
                    comment,
                    exponent,
                    decimal_comma: decimal_comma && !separator.contains(','),
                    epoch,
                };
                Just(columns).prop_shuffle().prop_map(move |order| Style {
                    order,
                    ..style.clone()
                })
            },
        )
}

fn motions() -> impl Strategy<Value = Written> {
    (1_usize..=4, 2_usize..8).prop_flat_map(|(axes, points)| {
        let steps = prop::collection::vec(1_u32..2_000, points);
        let angles = prop::collection::vec(prop::collection::vec(-720_000..720_000, points), axes);
        (steps, angles, styles(axes)).prop_map(|(steps, angles_mdeg, style)| {
            let mut now = 0;
            let times_ms = steps.iter().map(|step| {
                now += step;
                now
            });
            Written {
                times_ms: times_ms.collect(),
                angles_mdeg,
                style,
            }
        })
    })
}

impl Written {
    fn number(&self, value: f64) -> String {
        let text = if self.style.exponent {
            format!("{value:.17e}")
        } else {
            format!("{value}")
        };
        if self.style.decimal_comma {
            text.replace('.', ",")
        } else {
            text
        }
    }

    /// A time as digits, so that a stamp of an epoch loses nothing.
    fn time(&self, ms: u32) -> String {
        const EPOCH_MS: u64 = 1_700_000_000_000;
        let ms = u64::from(ms) + if self.style.epoch { EPOCH_MS } else { 0 };
        match self.style.time_name.1 {
            TimeUnit::S => {
                let point = if self.style.decimal_comma { ',' } else { '.' };
                format!("{}{point}{:03}", ms / 1_000, ms % 1_000)
            }
            TimeUnit::Ms => ms.to_string(),
            TimeUnit::Us => format!("{ms}000"),
            TimeUnit::Ns => format!("{ms}000000"),
        }
    }

    fn angle(&self, mdeg: i32) -> f64 {
        let degrees = f64::from(mdeg) / 1e3;
        match self.style.unit {
            Unit::Radians => degrees.to_radians(),
            Unit::Turns => degrees / 360.0,
            _ => degrees,
        }
    }

    fn line(&self, cells: &[String]) -> String {
        let ordered: Vec<&str> = self
            .style
            .order
            .iter()
            .map(|column| cells[*column].as_str())
            .collect();
        format!(
            "{}{}",
            ordered.join(self.style.separator),
            self.style.line_end
        )
    }

    fn header(&self) -> Vec<String> {
        let suffix = match self.style.unit {
            Unit::Radians => "_rad",
            Unit::Turns => "_turns",
            _ => "",
        };
        let axes = self
            .style
            .axis_names
            .iter()
            .map(|name| format!("{name}{suffix}"));
        let extras = self.style.extras.iter().map(|(name, _)| (*name).to_owned());
        core::iter::once(self.style.time_name.0.to_owned())
            .chain(axes)
            .chain(extras)
            .collect()
    }

    fn row(&self, point: usize) -> Vec<String> {
        let axes = self
            .angles_mdeg
            .iter()
            .map(|axis| self.number(self.angle(axis[point])));
        let extras = self
            .style
            .extras
            .iter()
            .map(|(_, value)| (*value).to_owned());
        core::iter::once(self.time(self.times_ms[point]))
            .chain(axes)
            .chain(extras)
            .collect()
    }

    fn rows(&self) -> Vec<Vec<String>> {
        (0..self.times_ms.len())
            .map(|point| self.row(point))
            .collect()
    }

    fn begin(&self) -> String {
        let mark = if self.style.mark { "\u{feff}" } else { "" };
        let comment = if self.style.comment {
            "# written by hand"
        } else {
            ""
        };
        let end = if self.style.comment {
            self.style.line_end
        } else {
            ""
        };
        format!("{mark}{comment}{end}")
    }

    fn text(&self, rows: &[Vec<String>]) -> String {
        let lines = rows.iter().map(|row| self.line(row));
        format!(
            "{}{}{}",
            self.begin(),
            self.line(&self.header()),
            lines.collect::<String>()
        )
    }

    fn reading(&self) -> Reading {
        Reading {
            choice: ColumnChoice::default(),
            time_unit: None,
            decimal_comma: self.style.decimal_comma,
            most_duration_s: 3_600.0,
            most_numbers: 10_000,
        }
    }

    fn read(&self, text: &str) -> Result<Table, TrajectoryError> {
        Table::read(text.as_bytes(), &self.reading())
    }

    /// The line of a point in the file.
    fn line_of(&self, point: usize) -> u64 {
        point as u64 + if self.style.comment { 3 } else { 2 }
    }

    /// Whether a table is this motion: its times, its axes in the order of the file, its units.
    fn is(&self, table: &Table) -> Result<(), TestCaseError> {
        let columns = &table.columns.positions;
        let units = resolve::position_units(&[], columns)
            .map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert!(units.iter().all(|unit| *unit == self.style.unit));
        prop_assert_eq!(&table.columns.time.label.name, self.style.time_name.0);
        let axes: Vec<usize> = self
            .style
            .order
            .iter()
            .filter(|column| (1..=self.angles_mdeg.len()).contains(*column))
            .map(|column| column - 1)
            .collect();
        prop_assert_eq!(columns.len(), axes.len());
        prop_assert_eq!(table.points(), self.times_ms.len());
        for point in 0..table.points() {
            let since_s = f64::from(self.times_ms[point] - self.times_ms[0]) / 1e3;
            prop_assert_eq!(table.times_s[point], since_s);
            prop_assert_eq!(table.lines[point], self.line_of(point));
            for (place, &axis) in axes.iter().enumerate() {
                let expected = self.angle(self.angles_mdeg[axis][point]);
                prop_assert!((table.row(point)[place] - expected).abs() < 1e-9);
            }
        }
        Ok(())
    }
}

/// A message that a user can act upon.
fn is_located(error: &TrajectoryError, line: u64) -> Result<(), TestCaseError> {
    let text = error.to_string();
    let begin = format!("line {line}");
    let rest = text.strip_prefix(&begin);
    prop_assert!(
        rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit())),
        "{} expected, got: {}",
        begin,
        text
    );
    Ok(())
}

/// A point and one of its columns that are read.
fn cell(written: &Written, seed: usize) -> (usize, usize) {
    let columns = written.angles_mdeg.len() + 1;
    (seed / columns % written.times_ms.len(), seed % columns)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_motion_is_the_same_however_it_is_written(written in motions()) {
        let table = written.read(&written.text(&written.rows()));
        let table = table.map_err(|error| TestCaseError::fail(error.to_string()))?;
        written.is(&table)?;
    }

    #[test]
    fn a_column_that_nobody_knows_moves_nothing(written in motions(), name in select(&STRANGERS[..]), seed in any::<usize>()) {
        let mut with_stranger = written;
        let style = &mut with_stranger.style;
        let column = style.order.len();
        style.extras.push((name, "7"));
        style.order.insert(seed % (column + 1), column);
        match with_stranger.read(&with_stranger.text(&with_stranger.rows())) {
            Err(error) => prop_assert!(error.to_string().contains("--columns"), "{}", error),
            Ok(table) => {
                let positions = &table.columns.positions;
                let units = resolve::position_units(&[], positions);
                let is_driven = positions.iter().any(|column| column.label.name == name);
                prop_assert!(!is_driven || units.is_err(), "{} moves an axis", name);
            }
        }
    }

    #[test]
    fn a_gap_is_refused_where_it_is(written in motions(), seed in any::<usize>()) {
        let (point, column) = cell(&written, seed);
        let mut rows = written.rows();
        rows[point][column].clear();
        let error = written.read(&written.text(&rows)).expect_err("a gap");
        is_located(&error, written.line_of(point))?;
    }

    #[test]
    fn a_missing_field_is_refused_where_it_is(written in motions(), seed in any::<usize>()) {
        let point = seed % written.times_ms.len();
        let mut lines: Vec<String> = written.rows().iter().map(|row| written.line(row)).collect();
        let cut = lines[point].trim_end().rfind(written.style.separator).expect("two columns");
        lines[point] = format!("{}{}", lines[point][..cut].trim_end(), written.style.line_end);
        let text = format!("{}{}{}", written.begin(), written.line(&written.header()), lines.concat());
        let error = written.read(&text).expect_err("a missing field");
        is_located(&error, written.line_of(point))?;
    }

    #[test]
    fn a_word_among_the_numbers_is_refused_where_it_is(
        written in motions(), seed in any::<usize>(), word in select(&["x", "NaN", "inf", "1.2.3", "--", "1e999", "0x10", "null", "1_000"][..])
    ) {
        let (point, column) = cell(&written, seed);
        let mut rows = written.rows();
        rows[point][column] = word.to_owned();
        let error = written.read(&written.text(&rows)).expect_err("no number");
        is_located(&error, written.line_of(point))?;
    }

    #[test]
    fn time_that_does_not_go_on_is_refused_where_it_stops(written in motions(), seed in any::<usize>()) {
        let point = 1 + seed % (written.times_ms.len() - 1);
        let mut rows = written.rows();
        rows[point][0] = rows[point - 1][0].clone();
        let error = written.read(&written.text(&rows)).expect_err("time that stands still");
        is_located(&error, written.line_of(point))?;
    }

    #[test]
    fn without_its_header_nothing_is_guessed(written in motions()) {
        let lines = written.rows().iter().map(|row| written.line(row)).collect::<String>();
        let text = format!("{}{lines}", written.begin());
        match written.read(&text) {
            // Two columns, of which the first alone increases.
            Ok(table) => {
                prop_assert_eq!(written.style.order.len(), 2);
                prop_assert_eq!(table.columns.time.index, 0);
                let second: Vec<f64> = table.axis(0).collect();
                prop_assert!(second.windows(2).any(|pair| pair[1] <= pair[0]));
            }
            Err(error) => prop_assert!(error.to_string().starts_with("line "), "{}", error),
        }
    }

    #[test]
    fn a_unit_in_a_name_against_the_option_is_refused(written in motions(), option in select(&[TimeUnit::S, TimeUnit::Ms, TimeUnit::Us, TimeUnit::Ns][..])) {
        let reading = Reading { time_unit: Some(option), most_duration_s: 1e30, ..written.reading() };
        let (name, unit) = written.style.time_name;
        let is_said = name.contains(['_', '[', '(', '/']) && name != "time_from_start" || matches!(name, "timeMs" | "seconds");
        match Table::read(written.text(&written.rows()).as_bytes(), &reading) {
            Ok(table) => {
                prop_assert!(!is_said || unit == option);
                prop_assert_eq!(table.time_unit, option);
            }
            Err(error) => {
                prop_assert!(is_said && unit != option, "{}", error);
                prop_assert!(error.to_string().contains("--time-unit"));
            }
        }
    }

    #[test]
    fn a_motion_that_lasts_too_long_says_how_long(written in motions()) {
        let reading = Reading { most_duration_s: 1e-3, ..written.reading() };
        let duration_ms = written.times_ms[written.times_ms.len() - 1] - written.times_ms[0];
        let read = Table::read(written.text(&written.rows()).as_bytes(), &reading);
        match read {
            Ok(_) => prop_assert!(duration_ms <= 1),
            Err(TrajectoryError::TooLong { duration_s, .. }) => prop_assert_eq!(duration_s, f64::from(duration_ms) / 1e3),
            Err(other) => prop_assert!(false, "{}", other),
        }
    }
}
