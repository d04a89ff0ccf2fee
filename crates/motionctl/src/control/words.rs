//! Orders as words: one a line.

use core::fmt;

use super::MOST_PERCENT;
use crate::set_points::Order;

/// A line that is no order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum WordError {
    /// Another word.
    Unknown { actual: String },
    /// An override without a percentage, or with another one than 0 to 200.
    Override { actual: String },
}

impl WordError {
    /// The number of the kind, see docs/stream.md.
    pub(crate) const fn number(&self) -> u16 {
        match self {
            Self::Unknown { .. } => 108,
            Self::Override { .. } => 109,
        }
    }
}

impl fmt::Display for WordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { actual } => write!(
                f,
                "no such word: expected pause, resume, override PERCENT, stop or status, got {}",
                actual.escape_debug()
            ),
            Self::Override { actual } => write!(
                f,
                "an override is a whole percentage: expected 0 to {MOST_PERCENT}, got {}",
                actual.escape_debug()
            ),
        }
    }
}

/// The order that a line is.
///
/// # Errors
/// [`WordError`].
pub(crate) fn order(line: &str) -> Result<Order, WordError> {
    let mut words = line.split_whitespace();
    let word = words.next().unwrap_or_default();
    let rest: Vec<&str> = words.collect();
    match (word, &rest[..]) {
        ("pause", []) => Ok(Order::Pause),
        ("resume", []) => Ok(Order::Resume),
        ("stop", []) => Ok(Order::Stop),
        ("override", rest) => {
            let text = rest.join(" ");
            match text.trim_end_matches('%').trim_end().parse() {
                Ok(percent) if percent <= MOST_PERCENT => Ok(Order::Override(percent)),
                _ => Err(WordError::Override { actual: text }),
            }
        }
        _ => Err(WordError::Unknown {
            actual: line.trim().chars().take(60).collect(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_words_and_everything_else_says_what_is_expected() {
        assert_eq!(order(" pause "), Ok(Order::Pause));
        assert_eq!(order("resume"), Ok(Order::Resume));
        assert_eq!(order("stop"), Ok(Order::Stop));
        assert_eq!(order("override 0"), Ok(Order::Override(0)));
        assert_eq!(order("override 200 %"), Ok(Order::Override(200)));
        for text in ["override", "override 201", "override -1", "override 50.5"] {
            let error = order(text).unwrap_err();
            assert!(error.to_string().contains("expected 0 to 200"), "{error}");
            assert_eq!(error.number(), 109);
        }
        for text in ["", "Pause", "pause now", "stop!", "\u{1b}[2J"] {
            let error = order(text).unwrap_err();
            assert!(
                error.to_string().contains("expected pause, resume"),
                "{error}"
            );
            assert!(!error.to_string().contains('\u{1b}'), "{error}");
            assert_eq!(error.number(), 108);
        }
    }
}
