//! The tables of a Markdown page: strict, with the line and column of everything.

use std::fmt;

/// Where something is on the page; both count from 1, columns in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// Something that is wrong with the page: where, what was expected, what is there, what to do.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Complaint {
    pub(crate) place: Place,
    pub(crate) text: String,
}

impl Complaint {
    pub(crate) fn new(place: Place, text: impl Into<String>) -> Self {
        Self {
            place,
            text: text.into(),
        }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { line, column } = self.place;
        write!(f, "{}:{line}:{column}: {}", crate::PAGE, self.text)
    }
}

/// One cell without the blanks around it.
#[derive(Debug, Clone)]
pub(crate) struct Cell<'a> {
    pub(crate) text: &'a str,
    pub(crate) place: Place,
}

/// A table under its heading.
#[derive(Debug)]
pub(crate) struct Table<'a> {
    pub(crate) heading: &'a str,
    pub(crate) place: Place,
    pub(crate) columns: Vec<Cell<'a>>,
    /// Each as long as `columns`.
    pub(crate) rows: Vec<Vec<Cell<'a>>>,
}

/// Every table of a page. A table belongs to the heading of level 2 above it, which has no other.
pub(crate) fn tables<'a>(text: &'a str, complaints: &mut Vec<Complaint>) -> Vec<Table<'a>> {
    let mut tables: Vec<Table<'a>> = Vec::new();
    let mut heading = "";
    let mut is_in_table = false;
    let mut lines = (1..).zip(text.lines()).peekable();
    while let Some((number, line)) = lines.next() {
        if let Some(words) = line.strip_prefix("## ") {
            heading = words.trim();
        }
        if !line.starts_with('|') {
            is_in_table = false;
            continue;
        }
        let cells = cells(number, line, complaints);
        let place = Place {
            line: number,
            column: 1,
        };
        match tables.last_mut() {
            Some(table) if is_in_table => push(table, cells, place, complaints),
            _ => {
                if tables.iter().any(|table| table.heading == heading) {
                    let text = format!(
                        "expected one table under \"{heading}\", found a second one: join them, or give it a heading of its own"
                    );
                    complaints.push(Complaint::new(place, text));
                }
                let is_rule = |line: &str| line.chars().all(|c| matches!(c, '|' | '-' | ':' | ' '));
                if lines.next_if(|(_, line)| is_rule(line)).is_none() {
                    let text = "expected the rule |---|---| below the names of the columns";
                    complaints.push(Complaint::new(place, text));
                }
                tables.push(Table {
                    heading,
                    place,
                    columns: cells,
                    rows: Vec::new(),
                });
                is_in_table = true;
            }
        }
    }
    tables
}

fn push<'a>(
    table: &mut Table<'a>,
    cells: Vec<Cell<'a>>,
    place: Place,
    complaints: &mut Vec<Complaint>,
) {
    let (expected, actual) = (table.columns.len(), cells.len());
    if expected == actual {
        table.rows.push(cells);
    } else {
        let text = format!("expected {expected} cells, found {actual}: every column has a cell");
        complaints.push(Complaint::new(place, text));
    }
}

fn cells<'a>(line_number: usize, line: &'a str, complaints: &mut Vec<Complaint>) -> Vec<Cell<'a>> {
    let whole = line.trim_end();
    if !whole.ends_with('|') || whole.len() < 2 {
        let place = Place {
            line: line_number,
            column: whole.chars().count(),
        };
        complaints.push(Complaint::new(place, "expected | at the end of the row"));
    }
    let inner = whole.strip_prefix('|').unwrap_or(whole);
    let inner = inner.strip_suffix('|').unwrap_or(inner);
    let mut column = 2;
    let mut cells = Vec::new();
    for raw in inner.split('|') {
        let blanks = raw.chars().take_while(|c| *c == ' ').count();
        cells.push(Cell {
            text: raw.trim(),
            place: Place {
                line: line_number,
                column: column + blanks,
            },
        });
        column += raw.chars().count() + 1;
    }
    cells
}
