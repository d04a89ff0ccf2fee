//! One line for each frame, as text or as JSON.

use std::io::{BufWriter, Stdout, Write};

use can_decode::log::Entry;
use can_decode::{Frame, Meaning};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::bus::Bus;
use super::meaning::MeaningFields;
use super::source::Damage;
use super::table::{Overview, table};
use crate::counted::counted;
use crate::output::tell;

/// Writes what was heard.
pub(super) struct Output {
    out: BufWriter<Stdout>,
    json: bool,
    source_name: String,
}

/// One line of JSON.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Line<'a> {
    /// A frame and its meaning.
    Frame {
        /// Nothing in a log without times.
        time_s: Option<f64>,
        interface: &'a str,
        id: u32,
        extended: bool,
        remote: bool,
        /// Two hexadecimal digits a byte.
        #[schemars(with = "String")]
        data: Hex<'a>,
        #[serde(serialize_with = "as_text")]
        #[schemars(with = "String")]
        text: &'a Meaning,
        #[serde(flatten)]
        #[schemars(with = "MeaningFields")]
        meaning: &'a Meaning,
    },
    /// Something else on the bus.
    Other {
        time_s: Option<f64>,
        interface: &'a str,
        text: &'a str,
    },
    /// A line of the log that cannot be read.
    Error { line: u64, error: String },
    /// Lines of the log in a row that cannot be read either.
    MoreErrors {
        first_line: u64,
        last_line: u64,
        lines: u64,
    },
    /// One interface, at the end.
    Statistics(Overview<'a>),
    /// The last line.
    End { damaged_lines: u64 },
}

/// Bytes without anything between them.
pub(super) struct Hex<'a>(&'a [u8]);

impl Serialize for Hex<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
        let mut text = String::with_capacity(2 * self.0.len());
        for byte in self.0 {
            text.push(char::from(DIGITS[usize::from(byte >> 4)]));
            text.push(char::from(DIGITS[usize::from(byte & 0xF)]));
        }
        serializer.serialize_str(&text)
    }
}

fn as_text<S: Serializer>(meaning: &Meaning, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(meaning)
}

impl Output {
    pub(super) fn new(json: bool, source_name: String) -> Self {
        Self {
            out: BufWriter::with_capacity(1 << 16, std::io::stdout()),
            json,
            source_name,
        }
    }

    pub(super) fn frame(
        &mut self,
        entry: &Entry<'_>,
        frame: &Frame,
        meaning: &Meaning,
    ) -> std::io::Result<()> {
        if self.json {
            return self.json_line(&Line::Frame {
                time_s: entry.at_ns.map(seconds),
                interface: entry.interface,
                id: frame.id(),
                extended: frame.is_extended(),
                remote: frame.is_remote(),
                data: Hex(frame.data()),
                text: meaning,
                meaning,
            });
        }
        self.time_and_interface(entry)?;
        writeln!(self.out, "{frame:27}  {meaning}")
    }

    pub(super) fn other(&mut self, entry: &Entry<'_>, text: &str) -> std::io::Result<()> {
        if self.json {
            return self.json_line(&Line::Other {
                time_s: entry.at_ns.map(seconds),
                interface: entry.interface,
                text,
            });
        }
        self.time_and_interface(entry)?;
        writeln!(self.out, "{:27}  {text}", "")
    }

    /// Errors go where errors go, in the order of the lines; with JSON they are lines like all others.
    pub(super) fn damaged(&mut self, line: u64, damage: &Damage) -> std::io::Result<()> {
        if self.json {
            return self.json_line(&Line::Error {
                line,
                error: damage.to_string(),
            });
        }
        self.out.flush()?;
        tell(format_args!("{}:{line}: {damage}", self.source_name));
        Ok(())
    }

    /// Damaged lines in a row that were not shown one by one.
    pub(super) fn more_damaged(
        &mut self,
        lines: u64,
        first: u64,
        last: u64,
    ) -> std::io::Result<()> {
        if self.json {
            return self.json_line(&Line::MoreErrors {
                first_line: first,
                last_line: last,
                lines,
            });
        }
        self.out.flush()?;
        let name = &self.source_name;
        tell(format_args!(
            "{name}:{first}: and {lines} more, up to line {last}, cannot be read either"
        ));
        Ok(())
    }

    /// What the reader should know about the whole log.
    pub(super) fn note(&mut self, note: &str) -> std::io::Result<()> {
        self.out.flush()?;
        tell(format_args!("note: {note}"));
        Ok(())
    }

    pub(super) fn statistics(&mut self, bus: &Bus, bit_rate_kbit: u32) -> std::io::Result<()> {
        let overview = Overview::new(bus, bit_rate_kbit);
        if self.json {
            return self.json_line(&Line::Statistics(overview));
        }
        writeln!(self.out, "\n{}\n{overview}", table(&bus.statistics))
    }

    pub(super) fn end(&mut self, damaged_lines: u64) -> std::io::Result<()> {
        if self.json {
            self.json_line(&Line::End { damaged_lines })?;
        } else {
            writeln!(
                self.out,
                "{}",
                counted(damaged_lines, "damaged line", "damaged lines")
            )?;
        }
        self.flush()
    }

    pub(super) fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }

    fn time_and_interface(&mut self, entry: &Entry<'_>) -> std::io::Result<()> {
        let Some(at_ns) = entry.at_ns else {
            return write!(self.out, "{:>12}  {:5} ", "-", entry.interface);
        };
        let us = at_ns / 1_000;
        write!(
            self.out,
            "{:5}.{:06}  {:5} ",
            us / 1_000_000,
            us % 1_000_000,
            entry.interface
        )
    }

    fn json_line(&mut self, line: &Line<'_>) -> std::io::Result<()> {
        serde_json::to_writer(&mut self.out, line)?;
        self.out.write_all(b"\n")
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}
