//! From the lines of a file to its points: first what the columns are, then one point a line.

use super::cells::{Cell, Separator, decimal_point};
use super::columns::{Columns, Unnamed};
use super::error::{ColumnLabel, Place, TrajectoryError};
use super::exact::ExactTime;
use super::name::{Name, Quantity};
use super::resolve;
use super::table::{Reading, Table};
use super::unit::TimeUnit;

/// A line of two numbers of which either may be time.
struct EitherRow {
    line: u64,
    fields: [String; 2],
    times: [ExactTime; 2],
}

/// Lines in which either of two columns may be time; more would take memory for what is refused in the end.
const MOST_EITHER_ROWS: usize = 1 << 16;

/// What is known of the columns.
enum Layout {
    /// No line yet.
    Unknown,
    Known(Columns, TimeUnit),
    /// Two columns without names.
    Either(Vec<EitherRow>),
}

/// Collects the points of a file, line by line.
pub(super) struct Reader<'a> {
    reading: &'a Reading,
    /// The last comment so far.
    comment: Option<String>,
    separator: Separator,
    layout: Layout,
    /// The line that says how many columns there are, how many, and their names.
    first_line: u64,
    width: usize,
    names: Vec<Name>,
    /// Time of the first point, and of the latest with its text.
    start: Option<ExactTime>,
    latest: Option<(ExactTime, String)>,
    points: usize,
    /// Where the motion became too long.
    too_long: Option<Place>,
    times_s: Vec<f64>,
    lines: Vec<u64>,
    positions: Vec<f64>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(reading: &'a Reading) -> Self {
        Self {
            reading,
            comment: None,
            separator: Separator::Blanks,
            layout: Layout::Unknown,
            first_line: 0,
            width: 0,
            names: Vec::new(),
            start: None,
            latest: None,
            points: 0,
            too_long: None,
            times_s: Vec::new(),
            lines: Vec::new(),
            positions: Vec::new(),
        }
    }

    /// A line that begins as a comment. Among the numbers it may be one of them: a spreadsheet writes `#DIV/0!` in the place of
    /// a number.
    pub(super) fn comment(&mut self, line: u64, text: &str) -> Result<(), TrajectoryError> {
        if matches!(self.layout, Layout::Unknown) {
            self.comment = Some(text.trim().to_owned());
            return Ok(());
        }
        let fields = self.separator.split(text);
        let cell = |field: &str| Cell::of(field, self.reading.decimal_comma);
        let is_number = |field: &String| matches!(cell(field), Cell::Number(_));
        if let [first, rest @ ..] = &fields[..]
            && self.separator != Separator::Blanks
            && fields.len() == self.width
            && first.len() > 1
            && !cell(first.trim_start_matches(['#', '%']).trim()).is_numeric()
            && rest.iter().all(is_number)
        {
            return Err(TrajectoryError::NotANumber {
                place: Place::cell(line, &self.label(0)),
                actual: first.clone(),
            });
        }
        Ok(())
    }

    pub(super) fn take(&mut self, line: u64, text: &str) -> Result<(), TrajectoryError> {
        if text.bytes().filter(|byte| *byte == b'"').count() % 2 != 0 {
            return Err(TrajectoryError::OpenQuote { line });
        }
        if !matches!(self.layout, Layout::Unknown) {
            let fields = self.separator.split(text);
            return self.numbers(line, &fields);
        }
        self.separator = Separator::of(text, self.reading.decimal_comma);
        let fields = self.separator.split(text);
        self.first_line = line;
        self.width = fields.len();
        if let Some(names) = self.names_of_comment(&fields) {
            self.names = names;
            self.choose_named(line)?;
        } else if self.is_header(line, &fields)? {
            self.names = fields.iter().map(|field| Name::parse(field)).collect();
            return self.choose_named(line);
        } else {
            if self.reading.choice.positions.is_empty() {
                // Before anything else: an empty field may be why the columns are not clear.
                for (index, field) in fields.iter().enumerate() {
                    self.number(line, index, field)?;
                }
            }
            self.choose_unnamed(line)?;
        }
        self.numbers(line, &fields)
    }

    /// The last comment names the columns when it has as many of them as a line with numbers, and time among them.
    fn names_of_comment(&self, fields: &[String]) -> Option<Vec<Name>> {
        let comment = self.comment.as_ref()?.trim_start_matches(['#', '%']);
        let words = self.separator.split(comment);
        let names: Vec<Name> = words.iter().map(|word| Name::parse(word)).collect();
        let has_number = fields
            .iter()
            .any(|field| Cell::of(field, self.reading.decimal_comma).is_numeric());
        let has_time = names.iter().any(|name| name.quantity == Quantity::Time);
        // A sentence may have as many words.
        let is_sentence = names.iter().any(|name| {
            let is_number = Cell::of(&name.text, self.reading.decimal_comma).is_numeric();
            name.quantity == Quantity::Unknown || is_number
        });
        let is_header = names.len() == fields.len() && has_number && has_time && !is_sentence;
        is_header.then_some(names)
    }

    /// Whether the first line is one of names; a line of both is refused.
    fn is_header(&self, line: u64, fields: &[String]) -> Result<bool, TrajectoryError> {
        let comma = self.reading.decimal_comma;
        let cell = |field: &String| Cell::of(field, comma);
        let number = fields.iter().position(|field| cell(field).is_numeric());
        let text = fields.iter().position(|field| cell(field).is_text());
        let at = |index: usize| (index + 1, fields[index].clone());
        if let Some(index) = fields
            .iter()
            .position(|field| cell(field) == Cell::DecimalComma)
        {
            return Err(TrajectoryError::DecimalComma {
                place: Place::cell(line, &self.label(index)),
                actual: fields[index].clone(),
            });
        }
        match (number, text) {
            (Some(number), Some(text)) => Err(TrajectoryError::MixedLine {
                line,
                number: at(number),
                text: at(text),
            }),
            (_, text) => Ok(text.is_some()),
        }
    }

    fn choose_named(&mut self, line: u64) -> Result<(), TrajectoryError> {
        let columns = Columns::named(&self.reading.choice, line, &self.names)?;
        self.set_layout(columns)
    }

    fn set_layout(&mut self, columns: Columns) -> Result<(), TrajectoryError> {
        let time_unit = resolve::time_unit(self.reading.time_unit, &columns.time)?;
        self.layout = Layout::Known(columns, time_unit);
        Ok(())
    }

    /// The options say which columns are which.
    fn choose_unnamed(&mut self, line: u64) -> Result<(), TrajectoryError> {
        match Columns::unnamed(&self.reading.choice, line, self.width)? {
            Unnamed::Known(columns) => self.set_layout(columns),
            Unnamed::Two => {
                self.layout = Layout::Either(Vec::new());
                Ok(())
            }
        }
    }

    fn label(&self, index: usize) -> ColumnLabel {
        ColumnLabel {
            number: index + 1,
            name: self
                .names
                .get(index)
                .map_or(String::new(), |name| name.text.clone()),
        }
    }

    fn numbers(&mut self, line: u64, fields: &[String]) -> Result<(), TrajectoryError> {
        if fields.len() != self.width {
            return Err(TrajectoryError::FieldCount {
                line,
                first_line: self.first_line,
                expected: self.width,
                actual: fields.len(),
                lacks: (fields.len() < self.width).then(|| self.label(fields.len())),
            });
        }
        if self.points * (self.axes() + 1) >= self.reading.most_numbers {
            let most = self.reading.most_numbers;
            return Err(TrajectoryError::TooLarge { line, most });
        }
        match &self.layout {
            Layout::Either(_) => self.either(line, fields),
            _ => self.point(line, fields),
        }
    }

    fn axes(&self) -> usize {
        match &self.layout {
            Layout::Known(columns, _) => columns.positions.len(),
            _ => 1,
        }
    }

    /// Keeps a line until the numbers say which of two columns is time.
    fn either(&mut self, line: u64, fields: &[String]) -> Result<(), TrajectoryError> {
        let row = EitherRow {
            line,
            times: [
                self.time(line, 0, &fields[0])?,
                self.time(line, 1, &fields[1])?,
            ],
            fields: [fields[0].clone(), fields[1].clone()],
        };
        self.points += 1;
        let Layout::Either(rows) = &mut self.layout else {
            return Ok(());
        };
        let rises = |index: usize| {
            rows.last()
                .is_none_or(|before| row.times[index] > before.times[index])
        };
        let rising = [rises(0), rises(1)];
        rows.push(row);
        if !rising[0] {
            return Err(self.no_names(&rising));
        }
        if rising[1] {
            return match rows.len() {
                MOST_EITHER_ROWS.. => Err(self.no_names(&rising)),
                _ => Ok(()),
            };
        }
        let rows = core::mem::take(rows);
        self.set_layout(Columns::by_number(0, &[1], 2))?;
        self.points = 0;
        for row in rows {
            self.point(row.line, &row.fields)?;
        }
        Ok(())
    }

    fn no_names(&self, rising: &[bool; 2]) -> TrajectoryError {
        let rising = (0..2).filter(|index| rising[*index]);
        TrajectoryError::NoNames {
            line: self.first_line,
            width: self.width,
            rising: Some(rising.map(|index| index + 1).collect()),
        }
    }

    fn time(&self, line: u64, index: usize, field: &str) -> Result<ExactTime, TrajectoryError> {
        self.number(line, index, field)?;
        let text = decimal_point(field, self.reading.decimal_comma);
        ExactTime::parse(&text).ok_or_else(|| TrajectoryError::NotANumber {
            place: Place::cell(line, &self.label(index)),
            actual: field.to_owned(),
        })
    }

    fn number(&self, line: u64, index: usize, field: &str) -> Result<f64, TrajectoryError> {
        let place = || Place::cell(line, &self.label(index));
        let actual = || field.to_owned();
        match Cell::of(field, self.reading.decimal_comma) {
            Cell::Number(value) => Ok(value),
            Cell::Missing => Err(TrajectoryError::Missing { place: place() }),
            Cell::NotFinite => Err(TrajectoryError::NotFinite {
                place: place(),
                actual: actual(),
            }),
            Cell::DecimalComma => Err(TrajectoryError::DecimalComma {
                place: place(),
                actual: actual(),
            }),
            Cell::Text => Err(TrajectoryError::NotANumber {
                place: place(),
                actual: actual(),
            }),
        }
    }

    /// One point of the motion.
    fn point(&mut self, line: u64, fields: &[String]) -> Result<(), TrajectoryError> {
        let Layout::Known(columns, time_unit) = &self.layout else {
            return Ok(());
        };
        let index = columns.time.index;
        let time = self.time(line, index, &fields[index])?;
        let start = *self.start.get_or_insert(time);
        let place = Place::cell(line, &columns.time.label);
        let since_s = time.seconds_since(start, time_unit.per_second());
        // Times that differ by less than a number can hold are the same time.
        let is_same = self
            .times_s
            .last()
            .is_some_and(|before_s| since_s <= *before_s);
        if let Some((before, text)) = &self.latest
            && (time <= *before || (is_same && self.too_long.is_none()))
        {
            return Err(TrajectoryError::TimeOrder {
                place,
                before: text.clone(),
                actual: fields[index].clone(),
            });
        }
        if since_s > self.reading.most_duration_s {
            self.too_long.get_or_insert(place);
        }
        let columns: Vec<usize> = columns
            .positions
            .iter()
            .map(|column| column.index)
            .collect();
        for column in columns {
            let value = self.number(line, column, &fields[column])?;
            if self.too_long.is_none() {
                self.positions.push(value);
            }
        }
        if self.too_long.is_none() {
            self.times_s.push(since_s);
            self.lines.push(line);
        }
        self.latest = Some((time, fields[index].clone()));
        self.points += 1;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<Table, TrajectoryError> {
        let (columns, time_unit) = match self.layout {
            Layout::Known(columns, time_unit) => (columns, time_unit),
            Layout::Either(rows) if rows.len() > 1 => {
                return Err(TrajectoryError::NoNames {
                    line: self.first_line,
                    width: self.width,
                    rising: Some(vec![1, 2]),
                });
            }
            Layout::Either(_) => {
                let line = self.first_line;
                return Err(TrajectoryError::SinglePoint { line });
            }
            Layout::Unknown => return Err(TrajectoryError::Empty),
        };
        if let (Some(place), Some((latest, _)), Some(start)) =
            (self.too_long, self.latest, self.start)
        {
            return Err(TrajectoryError::TooLong {
                place,
                duration_s: latest.seconds_since(start, time_unit.per_second()),
                most_s: self.reading.most_duration_s,
                unit: time_unit,
            });
        }
        match self.lines[..] {
            [] => Err(TrajectoryError::Empty),
            [line] => Err(TrajectoryError::SinglePoint { line }),
            _ => Ok(Table {
                columns,
                time_unit,
                times_s: self.times_s,
                lines: self.lines,
                positions: self.positions,
            }),
        }
    }
}
