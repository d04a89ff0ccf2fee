//! What a line is: names, a set-point, an order, or an error with its number.

use core::fmt;
use std::sync::Arc;

use serde::Deserialize;
use serde::de::{MapAccess, Visitor};

use crate::control::{WordError, broken, order};
use crate::endpoint::Line;
use crate::set_points::Order;
use crate::trajectory::{FieldError, Layout, MotionOptions, TimedCounts};

/// Most names of a line as JSON.
const MOST_NAMES: usize = 256;

/// A line that can be used.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Parsed {
    /// The names are known from now on.
    Names(Arc<Layout>),
    /// A set-point; names of JSON may come with the first one.
    SetPoint(TimedCounts, Option<Arc<Layout>>),
    Order(Order),
    Status,
    /// No set-point comes any more.
    End,
    /// A comment or an empty line.
    Nothing,
}

/// A line that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LineError {
    pub(super) number: u16,
    pub(super) text: String,
}

impl LineError {
    fn new(number: u16, text: impl fmt::Display) -> Self {
        Self {
            number,
            text: text.to_string(),
        }
    }
}

impl From<FieldError> for LineError {
    fn from(error: FieldError) -> Self {
        let number = match &error {
            FieldError::Count { .. } => 105,
            FieldError::NotANumber { .. } => 106,
            FieldError::NotFinite { .. } => 107,
        };
        Self::new(number, error)
    }
}

impl From<WordError> for LineError {
    fn from(error: WordError) -> Self {
        Self::new(error.number(), error)
    }
}

/// Reads lines of one sender.
pub(super) struct Parser<'a> {
    options: &'a MotionOptions,
    axes: usize,
    layout: Option<Arc<Layout>>,
    /// Every line is JSON.
    is_json: bool,
}

impl<'a> Parser<'a> {
    pub(super) fn new(options: &'a MotionOptions, axes: usize) -> Self {
        Self {
            options,
            axes,
            layout: None,
            is_json: false,
        }
    }

    /// Whether the sender speaks JSON, so that it is answered in JSON.
    pub(super) fn is_json(&self) -> bool {
        self.is_json
    }

    /// What a line is; `number` from 1.
    pub(super) fn line(&mut self, number: u64, line: &Line) -> Result<Parsed, LineError> {
        let Line::Text(text) = line else {
            let (code, text) = broken(line);
            return Err(LineError::new(code, text));
        };
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.starts_with('{') {
            self.is_json = true;
            return self.object(number, text);
        }
        if text.is_empty() {
            return Ok(Parsed::Nothing);
        }
        // Words are looked at first: no column is called so.
        match text {
            "end" => return Ok(Parsed::End),
            "status" => return Ok(Parsed::Status),
            _ => {}
        }
        let begins_with = text.split_whitespace().next().unwrap_or_default();
        if ["pause", "resume", "override", "stop"].contains(&begins_with) {
            return Ok(Parsed::Order(order(text)?));
        }
        match &self.layout {
            None => self.names(number, text),
            Some(_) if text.starts_with(['#', '%']) => Ok(Parsed::Nothing),
            Some(layout) => {
                let is_word = text.starts_with(|c: char| c.is_alphabetic())
                    && !text.contains([',', ';', '\t']);
                if is_word {
                    // It says which words there are.
                    return Ok(Parsed::Order(order(text)?));
                }
                let set_point = layout.set_point(text, self.options.decimal_comma())?;
                Ok(Parsed::SetPoint(set_point, None))
            }
        }
    }

    fn names(&mut self, number: u64, text: &str) -> Result<Parsed, LineError> {
        let refused = |error: &dyn fmt::Display| LineError::new(104, error);
        let layout = self
            .options
            .layout(number, text, self.axes)
            .map_err(|error| refused(&error))?;
        let Some(layout) = layout else {
            return Err(refused(
                &"the first line must name the columns, as in time_s,x_deg,y_deg: expected names, got numbers",
            ));
        };
        let layout = Arc::new(layout);
        self.layout = Some(Arc::clone(&layout));
        Ok(Parsed::Names(layout))
    }

    fn object(&mut self, number: u64, text: &str) -> Result<Parsed, LineError> {
        let Fields(fields) =
            serde_json::from_str(text).map_err(|error| LineError::new(110, error))?;
        if let Some((_, Value::Text(word))) = fields.iter().find(|(name, _)| name == "order") {
            return self.word_of(word, &fields);
        }
        let mut values = Vec::with_capacity(fields.len());
        for (name, value) in fields {
            match value {
                Value::Number(value) => values.push((name, value)),
                Value::Text(text) => {
                    let shown: String = text.chars().take(40).collect();
                    return Err(LineError::new(
                        106,
                        format_args!(
                            "{}: expected a number, got the text {shown:?}",
                            name.escape_debug()
                        ),
                    ));
                }
            }
        }
        let (layout, is_new) = match &self.layout {
            Some(layout) => (Arc::clone(layout), false),
            None => {
                let names: Vec<String> = values.iter().map(|(name, _)| name.clone()).collect();
                let layout = self
                    .options
                    .named_layout(number, &names, self.axes)
                    .map_err(|error| LineError::new(104, error))?;
                (Arc::new(layout), true)
            }
        };
        let set_point = layout.named_set_point(&values)?;
        self.layout = Some(Arc::clone(&layout));
        Ok(Parsed::SetPoint(set_point, is_new.then_some(layout)))
    }

    fn word_of(&self, word: &str, fields: &[(String, Value)]) -> Result<Parsed, LineError> {
        match word {
            "end" => return Ok(Parsed::End),
            "status" => return Ok(Parsed::Status),
            _ => {}
        }
        let percent = fields.iter().find(|(name, _)| name == "percent");
        let words = match percent {
            Some((_, Value::Number(percent))) => format!("{word} {percent}"),
            Some((_, Value::Text(percent))) => format!("{word} {percent}"),
            None => word.to_owned(),
        };
        Ok(Parsed::Order(order(&words)?))
    }
}

/// A number or a text of a JSON object.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
enum Value {
    Number(f64),
    Text(String),
}

/// The fields of a JSON object in their order, which is that of the axes.
struct Fields(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;

        impl<'de> Visitor<'de> for InOrder {
            type Value = Fields;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of names and numbers")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields, A::Error> {
                let mut fields: Vec<(String, Value)> = Vec::new();
                while let Some((name, value)) = map.next_entry::<String, Value>()? {
                    if fields.iter().any(|(other, _)| *other == name) {
                        return Err(serde::de::Error::custom(format_args!(
                            "{name:?} is there twice"
                        )));
                    }
                    if fields.len() == MOST_NAMES {
                        return Err(serde::de::Error::custom(format_args!(
                            "expected at most {MOST_NAMES} names, got more"
                        )));
                    }
                    fields.push((name, value));
                }
                Ok(Fields(fields))
            }
        }

        deserializer.deserialize_map(InOrder)
    }
}

#[cfg(test)]
mod tests;
