//! The times of candump: absolute, with a date, from the first frame on, from frame to frame, or none at all.
//!
//! Only their look and their order tell one from the other (`sprint_timestamp` of can-utils): ten digits in front of the point are
//! absolute (`-t a`, `-L`), three are counted from the first frame (`-t z`) or from the frame before (`-t d`). The latter go back
//! again and again, the former never do.

use super::error::LineError;
use super::fields::{TIME, Words, time_ns, without_colours};

const NS_PER_S: u64 = 1_000_000_000;
/// Fewest digits of a time that counts from 1970.
const ABSOLUTE_DIGITS: usize = 10;
/// Digits of a time that counts from the first frame or from the one before.
const PADDED_DIGITS: usize = 3;

/// How to read times that count from the first frame or from the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stamps {
    /// From the first frame (`candump -t z`).
    Zero,
    /// From the frame before (`candump -t d`).
    Delta,
}

/// What the times so far tell.
#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    /// How short times are read, when it is known.
    pub(super) stamps: Option<Stamps>,
    /// Lines that were looked at have short times, and none of them goes back.
    pub(super) assumes_zero: bool,
    /// Whether lines have a time, once one of them has told it.
    has_times: Option<bool>,
    /// Sum of the differences.
    sum_ns: u64,
    latest_ns: u64,
}

impl Clock {
    /// Looks at lines that will be read later, to tell differences from times.
    pub(super) fn look_ahead<'a>(&mut self, lines: impl Iterator<Item = &'a str>) {
        let (mut latest_ns, mut most_ns) = (0, 0);
        for line in lines {
            let mut words = Words::of(line);
            let Some(time_ns) = words.next_if_any().and_then(short_time_ns) else {
                continue;
            };
            // The log of candump -L never has differences.
            if words.any_is_log_frame() {
                continue;
            }
            // Several interfaces may be out of order by a little; differences fall far below the largest of them.
            if time_ns < latest_ns && time_ns < most_ns / 2 {
                self.stamps = Some(Stamps::Delta);
                self.assumes_zero = false;
                return;
            }
            self.assumes_zero = true;
            latest_ns = time_ns;
            most_ns = most_ns.max(time_ns);
        }
    }

    /// The time in front of a line; `None` for a line without one.
    pub(super) fn read(&mut self, words: &mut Words<'_>) -> Result<Option<u64>, LineError> {
        let has_time = words.peek().is_some_and(|word| word.starts_with('('));
        if *self.has_times.get_or_insert(has_time) != has_time {
            let actual = words.peek().unwrap_or_default();
            let expected = if has_time {
                "no time, as in the lines before"
            } else {
                "a time in brackets"
            };
            return Err(LineError::field(expected, actual));
        }
        if !has_time {
            return Ok(None);
        }
        let first = words.next(TIME)?;
        if let Some(date) = first
            .strip_prefix('(')
            .filter(|date| date.contains('-') && !first.ends_with(')'))
        {
            let time = words.next(TIME)?;
            return date_ns(date, time).map(Some);
        }
        let inside = first
            .strip_prefix('(')
            .and_then(|time| time.strip_suffix(')'));
        let inside = inside.ok_or_else(|| LineError::field("a time in brackets", first))?;
        let time = time_ns(inside, NS_PER_S)?;
        if !is_short(inside) || words.any_is_log_frame() {
            return Ok(Some(time));
        }
        self.short(time).map(Some)
    }

    /// A time of three digits.
    fn short(&mut self, time_ns: u64) -> Result<u64, LineError> {
        let before_ns = core::mem::replace(&mut self.latest_ns, time_ns);
        match self.stamps {
            Some(Stamps::Delta) => {
                self.sum_ns = self.sum_ns.saturating_add(time_ns);
                Ok(self.sum_ns)
            }
            Some(Stamps::Zero) => Ok(time_ns),
            None if time_ns < before_ns && time_ns < before_ns / 2 => Err(LineError::Differences {
                before_ns,
                at_ns: time_ns,
            }),
            None => Ok(time_ns),
        }
    }
}

impl Words<'_> {
    /// Whether one of the next words is a frame of the log format, as `029#00`.
    fn any_is_log_frame(&self) -> bool {
        let mut words = self.clone();
        words.next_if_any();
        words.next_if_any().is_some_and(|frame| frame.contains('#'))
    }
}

/// A time such as `(000.000621)`.
fn short_time_ns(word: &str) -> Option<u64> {
    let inside = without_colours(word).strip_prefix('(')?.strip_suffix(')')?;
    time_ns(inside, NS_PER_S).ok().filter(|_| is_short(inside))
}

/// Whether a time has as many digits in front of the point as those that do not count from 1970.
fn is_short(time: &str) -> bool {
    let digits = time.bytes().position(|byte| byte == b'.');
    digits.is_some_and(|digits| (PADDED_DIGITS..ABSOLUTE_DIGITS).contains(&digits))
}

/// `2026-11-28` and `10:00:00.123456)` as the time since 1970 in the zone of the log.
fn date_ns(date: &str, time: &str) -> Result<u64, LineError> {
    let bad_date = || LineError::field("a date such as 2026-11-28", date);
    let mut parts = date.splitn(3, '-').map(|part| part.parse::<u64>().ok());
    let mut part = |most| parts.next().flatten().filter(|part| *part <= most);
    let (Some(year), Some(month), Some(day)) = (part(9_999), part(12), part(31)) else {
        return Err(bad_date());
    };
    if year < 1970 || month == 0 || day == 0 {
        return Err(bad_date());
    }
    let bad_time = || LineError::field("a time such as 10:00:00.123456)", time);
    let clock = time.strip_suffix(')').ok_or_else(bad_time)?;
    let mut parts = clock.splitn(3, ':');
    let (Some(hours), Some(minutes), Some(seconds)) = (parts.next(), parts.next(), parts.next())
    else {
        return Err(bad_time());
    };
    let number = |text: &str, most: u64| text.parse().ok().filter(|value| *value <= most);
    let hours: u64 = number(hours, 23).ok_or_else(bad_time)?;
    let minutes: u64 = number(minutes, 59).ok_or_else(bad_time)?;
    let seconds_ns = time_ns(seconds, NS_PER_S)?;
    let minutes = (days_since_1970(year, month, day) * 24 + hours) * 60 + minutes;
    Ok(minutes * 60 * NS_PER_S + seconds_ns.min(61 * NS_PER_S))
}

/// Days of the Gregorian calendar, with years that begin in March.
fn days_since_1970(year: u64, month: u64, day: u64) -> u64 {
    const TO_1970: u64 = 719_468;
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days_of_years = 365 * year + year / 4 - year / 100 + year / 400;
    days_of_years + (153 * month + 2) / 5 + day - 1 - TO_1970
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates() {
        // date -u -d ... +%s
        for (date, time, s) in [
            ("1970-01-01", "00:00:00.0)", 0),
            ("2000-02-29", "12:00:00.0)", 951_825_600),
            ("2026-11-28", "10:00:00.0)", 1_795_860_000),
        ] {
            assert_eq!(date_ns(date, time), Ok(s * NS_PER_S), "{date}");
        }
        for (date, time) in [
            ("2026-13-01", "00:00:00)"),
            ("2026-11", "00:00:00)"),
            ("2026-00-28", "00:00:00)"),
            ("2026-11-00", "00:00:00)"),
            ("2026-11-32", "00:00:00)"),
            ("2026-11-28", "24:00:00)"),
            ("2026-11-28", "10:00:00"),
            ("1969-12-31", "00:00:00)"),
        ] {
            assert!(date_ns(date, time).is_err(), "{date} {time}");
        }
    }

    #[test]
    fn differences_go_back() {
        let stamps = |lines: &[&str]| {
            let mut clock = Clock::default();
            clock.look_ahead(lines.iter().copied());
            clock.stamps
        };
        let line = |time: &str| format!(" ({time})  can0  029   [0] ");
        let lines = ["000.000000", "000.000621", "000.019000", "000.000622"].map(line);
        assert_eq!(
            stamps(&lines.each_ref().map(String::as_str)),
            Some(Stamps::Delta)
        );
        let lines = ["000.000000", "000.500000", "000.499990", "012.000000"].map(line);
        assert_eq!(stamps(&lines.each_ref().map(String::as_str)), None);
        assert_eq!(
            stamps(&["(000.019000) can0 029#", "(000.000100) can0 029#"]),
            None
        );
    }
}
