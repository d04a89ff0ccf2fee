//! The fields of a line, and what each of them is.

use csv::ReaderBuilder;

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Tab,
    Semicolon,
    Comma,
    /// Any number of blanks; a line may begin and end with some.
    Blanks,
}

impl Separator {
    /// The separator of a line. A tab or a semicolon is one wherever it stands; a comma beside one of them is part of a
    /// number or of a name, and so it is with decimal commas.
    pub(super) fn of(line: &str, decimal_comma: bool) -> Self {
        if line.contains(';') {
            Self::Semicolon
        } else if line.trim().contains('\t') {
            Self::Tab
        } else if line.contains(',') && !decimal_comma {
            Self::Comma
        } else {
            Self::Blanks
        }
    }

    /// The fields of a line without the blanks around them; empty fields keep their place.
    pub(super) fn split(self, line: &str) -> Vec<String> {
        let owned = |field: &str| field.trim().to_owned();
        let byte = match self {
            Self::Blanks => return line.split_whitespace().map(str::to_owned).collect(),
            Self::Tab => b'\t',
            Self::Semicolon => b';',
            Self::Comma => b',',
        };
        if !line.contains('"') {
            return line.split(char::from(byte)).map(owned).collect();
        }
        let mut quoted = ReaderBuilder::new()
            .delimiter(byte)
            .has_headers(false)
            .from_reader(line.as_bytes());
        let record = quoted.records().next().and_then(Result::ok);
        record.map_or_else(Vec::new, |record| record.iter().map(owned).collect())
    }
}

/// What a field is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    /// Infinite, or the word for no number.
    NotFinite,
    Missing,
    /// A number if its comma is a decimal comma.
    DecimalComma,
    Text,
}

impl Cell {
    pub(super) fn of(field: &str, decimal_comma: bool) -> Self {
        if field.is_empty() {
            return Self::Missing;
        }
        let number = if decimal_comma {
            with_point(field)
        } else {
            field.parse().ok()
        };
        match number {
            Some(value) if value.is_finite() => Self::Number(value),
            Some(_) => Self::NotFinite,
            None if !decimal_comma && with_point(field).is_some() => Self::DecimalComma,
            None => Self::Text,
        }
    }

    pub(super) fn is_text(self) -> bool {
        self == Self::Text
    }

    /// Whether it cannot be a name.
    pub(super) fn is_numeric(self) -> bool {
        matches!(self, Self::Number(_) | Self::NotFinite | Self::DecimalComma)
    }
}

/// A number whose comma is the decimal one; a point beside it would be a guess.
fn with_point(field: &str) -> Option<f64> {
    if field.contains('.') {
        return None;
    }
    field.replacen(',', ".", 1).parse().ok()
}

/// A number as it stands in a file, with a decimal point.
pub(super) fn decimal_point(field: &str, decimal_comma: bool) -> String {
    if decimal_comma {
        field.replacen(',', ".", 1)
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str) -> Vec<String> {
        Separator::of(line, false).split(line)
    }

    #[test]
    fn empty_fields_keep_their_place() {
        assert_eq!(split("0,,1"), ["0", "", "1"]);
        assert_eq!(split("0;;1;"), ["0", "", "1", ""]);
        assert_eq!(split("0\t\t1"), ["0", "", "1"]);
        assert_eq!(split("  0   1 "), ["0", "1"]);
        assert_eq!(split("\"a, b\",\"c\""), ["a, b", "c"]);
    }

    #[test]
    fn a_comma_beside_another_separator_is_decimal() {
        assert_eq!(split("0,5;1,5"), ["0,5", "1,5"]);
        assert_eq!(Separator::of("0,5 1,5", true), Separator::Blanks);
    }

    #[test]
    fn what_fields_are() {
        assert_eq!(Cell::of("1e-3", false), Cell::Number(1e-3));
        assert_eq!(Cell::of("NaN", false), Cell::NotFinite);
        assert_eq!(Cell::of("", false), Cell::Missing);
        assert_eq!(Cell::of("0,5", false), Cell::DecimalComma);
        assert_eq!(Cell::of("0,5", true), Cell::Number(0.5));
        assert_eq!(Cell::of("1.234,5", true), Cell::Text);
        assert_eq!(Cell::of("1.5", true), Cell::Text);
        assert_eq!(Cell::of("x", false), Cell::Text);
    }
}
