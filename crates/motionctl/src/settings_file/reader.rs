//! Reads a file of settings. Every key is known, every value is there, in its range and said once: nothing is guessed.

use core::ops::Range;

use board_settings::file::{FileError, Place};
use clap::ValueEnum;
use dyn_can::StoredDriveId;
use toml::Spanned;
use toml::de::{DeInteger, DeString, DeTable, DeValue};

use super::{DriveSettings, FORMAT, FileRevision};
use crate::drives::{Parameter, Setting};

/// Stands for a drive without a line number.
const NO_LINE_NUMBER: i32 = 0;

const BACK_UP: &str = "make a file with `motionctl backup` and compare";

/// Reads the text of a file.
///
/// # Errors
/// [`FileError`]: the first thing that is wrong, with its place.
pub(crate) fn parse(text: &str) -> Result<Vec<DriveSettings>, FileError> {
    let reader = Reader { text };
    let file = DeTable::parse(text).map_err(|error| reader.syntax(&error))?;
    let table = Table {
        reader,
        of: "the file",
        span: 0..0,
        table: file.get_ref(),
    };
    table.require_known(&["format", "tool", "date", "drive"])?;
    let format = table.integer("format", "the number of a format")?;
    if format.value != FORMAT {
        return Err(reader.error(
            &format.span,
            format!("format = {FORMAT}"),
            format!("format = {}", format.value),
            "use the version of this tool that wrote it",
        ));
    }
    table.string("tool", "the name and version of the tool that wrote it")?;
    let date = table.require("date", "the date of the backup")?;
    if !date.get_ref().is_datetime() {
        return Err(reader.wrong_kind(date, "a date, as in 2026-11-29T05:42:14Z"));
    }
    let mut drives: Vec<DriveSettings> = Vec::new();
    for table in table.drives()? {
        let (id_span, drive) = drive(&table)?;
        if drives.iter().any(|other| other.id == drive.id) {
            return Err(reader.error(
                &id_span,
                "each drive once".to_owned(),
                format!("drive {} a second time", drive.id),
                "remove one of the two",
            ));
        }
        drives.push(drive);
    }
    Ok(drives)
}

fn drive(table: &Table<'_>) -> Result<(Range<usize>, DriveSettings), FileError> {
    let reader = table.reader;
    let names: Vec<String> = Parameter::value_variants()
        .iter()
        .map(ToString::to_string)
        .collect();
    let mut known = vec!["id", "revision"];
    known.extend(names.iter().map(String::as_str));
    table.require_known(&known)?;
    let id = table.integer("id", "a drive id from 0 to 63")?;
    let number = i32::try_from(id.value).ok();
    let stored = number.and_then(|number| StoredDriveId::new(number).ok());
    let Some(stored) = stored else {
        return Err(reader.error(
            &id.span,
            "a drive id from 0 to 63".to_owned(),
            id.value.to_string(),
            "write the id of the drive",
        ));
    };
    let revision = revision(table)?;
    let mut settings = Vec::new();
    for &parameter in Parameter::value_variants() {
        // The serial port does not reach it.
        let is_optional = parameter == Parameter::LineNumber && revision == FileRevision::Unknown;
        if is_optional && table.get(&parameter.to_string()).is_none() {
            continue;
        }
        settings.extend(setting(table, parameter)?);
    }
    settings.sort_unstable_by_key(|setting| setting.parameter);
    Ok((
        id.span,
        DriveSettings {
            id: stored,
            revision,
            settings,
        },
    ))
}

fn revision(table: &Table<'_>) -> Result<FileRevision, FileError> {
    let text = table.string("revision", "the revision of the drive")?;
    let mut all = FileRevision::ALL.into_iter();
    all.find(|known| known.to_string() == text.value)
        .ok_or_else(|| {
            table.reader.error(
                &text.span,
                "revision \"1.2A\", \"1.6A\" or \"unknown\"".to_owned(),
                format!("\"{}\"", text.value),
                "`motionctl scan` shows the revision of a drive",
            )
        })
}

/// A setting in its range; `None` for a line number that the drive does not have.
fn setting(table: &Table<'_>, parameter: Parameter) -> Result<Option<Setting>, FileError> {
    let (least, most) = parameter.limits();
    let range = if parameter == Parameter::LineNumber {
        format!("{parameter} from {least} to {most}, or {NO_LINE_NUMBER} for none")
    } else {
        format!("{parameter} from {least} to {most}")
    };
    let number = table.integer(&parameter.to_string(), &range)?;
    let value = i32::try_from(number.value).ok();
    if parameter == Parameter::LineNumber && value == Some(NO_LINE_NUMBER) {
        return Ok(None);
    }
    let error = |expected, actual| {
        let advice = format!("write a value of {parameter} that the drive can store");
        table.reader.error(&number.span, expected, actual, &advice)
    };
    let in_range = value.filter(|value| (least..=most).contains(value));
    let Some(value) = in_range else {
        return Err(error(range, number.value.to_string()));
    };
    Setting::new(parameter, value)
        .map(Some)
        .map_err(|fault| error(range, format!("{value} ({fault})")))
}

/// A value with its place.
struct Located<T> {
    value: T,
    span: Range<usize>,
}

/// A table with the words for it.
struct Table<'a> {
    reader: Reader<'a>,
    of: &'static str,
    /// Where the absence of a key is shown.
    span: Range<usize>,
    table: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let mut entries = self.table.iter();
        entries
            .find(|(name, _)| name.get_ref() == key)
            .map(|(_, value)| value)
    }

    fn require_known(&self, known: &[&str]) -> Result<(), FileError> {
        let is_unknown =
            |name: &&'a Spanned<DeString<'a>>| !known.contains(&name.get_ref().as_ref());
        let unknown = self.table.keys().filter(is_unknown);
        match unknown.min_by_key(|name| name.span().start) {
            None => Ok(()),
            Some(name) => Err(self.reader.error(
                &name.span(),
                format!("a key of {}: {}", self.of, known.join(", ")),
                format!("\"{}\"", name.get_ref()),
                "correct or remove it",
            )),
        }
    }

    fn require(&self, key: &str, what: &str) -> Result<&'a Spanned<DeValue<'a>>, FileError> {
        self.get(key).ok_or_else(|| {
            self.reader.error(
                &self.span,
                format!("`{key}` in {}: {what}", self.of),
                "nothing".to_owned(),
                &format!("add it, or {BACK_UP}"),
            )
        })
    }

    fn integer(&self, key: &str, what: &str) -> Result<Located<i64>, FileError> {
        let value = self.require(key, what)?;
        let DeValue::Integer(integer) = value.get_ref() else {
            return Err(self.reader.wrong_kind(value, what));
        };
        let span = value.span();
        match number(integer) {
            Some(value) => Ok(Located { value, span }),
            None => Err(self.reader.error(
                &span,
                what.to_owned(),
                self.reader.excerpt(&span),
                "write a number that fits",
            )),
        }
    }

    fn string(&self, key: &str, what: &str) -> Result<Located<String>, FileError> {
        let value = self.require(key, what)?;
        match value.get_ref() {
            DeValue::String(text) => Ok(Located {
                value: text.to_string(),
                span: value.span(),
            }),
            _ => Err(self.reader.wrong_kind(value, what)),
        }
    }

    /// The tables under `[[drive]]`, at least one.
    fn drives(&self) -> Result<Vec<Table<'a>>, FileError> {
        let what = "a table [[drive]] for each drive";
        let value = self.require("drive", what)?;
        let DeValue::Array(array) = value.get_ref() else {
            return Err(self.reader.wrong_kind(value, what));
        };
        let mut tables = Vec::new();
        for entry in array.iter() {
            let DeValue::Table(table) = entry.get_ref() else {
                return Err(self.reader.wrong_kind(entry, what));
            };
            tables.push(Table {
                reader: self.reader,
                of: "[[drive]]",
                span: entry.span(),
                table,
            });
        }
        if tables.is_empty() {
            return Err(self.reader.error(
                &value.span(),
                what.to_owned(),
                "none".to_owned(),
                BACK_UP,
            ));
        }
        Ok(tables)
    }
}

fn number(integer: &DeInteger<'_>) -> Option<i64> {
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// Knows the text, for places in it.
#[derive(Clone, Copy)]
struct Reader<'a> {
    text: &'a str,
}

impl Reader<'_> {
    fn error(
        &self,
        span: &Range<usize>,
        expected: String,
        actual: String,
        advice: &str,
    ) -> FileError {
        FileError {
            place: Place::of(self.text, span.start),
            expected,
            actual,
            advice: advice.to_owned(),
        }
    }

    fn wrong_kind(&self, value: &Spanned<DeValue<'_>>, expected: &str) -> FileError {
        let kind = value.get_ref().type_str();
        let actual = match value.get_ref() {
            DeValue::Array(_) | DeValue::Table(_) => format!("a TOML {kind}"),
            _ => format!("{} (a TOML {kind})", self.excerpt(&value.span())),
        };
        self.error(&value.span(), expected.to_owned(), actual, "correct it")
    }

    /// What stands there, cut when it is long.
    fn excerpt(&self, span: &Range<usize>) -> String {
        /// Characters that are shown.
        const MOST: usize = 40;
        let text = self.text.get(span.clone()).unwrap_or_default();
        let line = text.lines().next().unwrap_or_default();
        match line.char_indices().nth(MOST) {
            None => line.to_owned(),
            Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
        }
    }

    fn syntax(&self, error: &toml::de::Error) -> FileError {
        let span = error.span().unwrap_or_default();
        let excerpt = self.excerpt(&span);
        let actual = if excerpt.is_empty() {
            error.message().to_owned()
        } else {
            format!("\"{excerpt}\" ({})", error.message())
        };
        self.error(
            &span,
            "TOML".to_owned(),
            actual,
            "correct the line: key = value, or a heading [[drive]]",
        )
    }
}
