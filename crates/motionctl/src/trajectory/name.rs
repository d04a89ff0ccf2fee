//! What the name of a column says about it: the quantity, where it comes from, and its unit.
//!
//! Nothing is concluded from the numbers: a circle has an axis that is the derivative of the other.

mod vocabulary;

use super::unit::{TimeUnit, Unit};
use vocabulary::{
    ACCELERATIONS, AXES, BEHIND_TIME, COMMANDED, COUNTERS, DEVIATIONS, ELECTRICAL, FORCES, FOREIGN,
    MEASURED, POSITIONS, SPEEDS, STATES, TIMES,
};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    /// The name says that it is a position.
    Position,
    /// The name is that of an axis and says nothing about the quantity, as `shoulder`.
    Unnamed,
    /// One word that is not known: an axis only where nothing else can be one.
    Unknown,
    Speed,
    /// Something that is neither position nor speed.
    Other(&'static str),
    /// The name may mean another quantity or an axis, as `v` and `x_filtered`.
    Unclear,
}

/// Who produced the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    Unsaid,
    Commanded,
    Measured,
}

/// The unit that a name carries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum NamedUnit {
    Unsaid,
    Time(TimeUnit),
    /// Of a position, or of the speed of a wheel.
    Position(Unit),
    /// A unit that no column can be read in.
    Foreign(String),
}

/// A column name, taken apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    pub(super) text: String,
    pub(super) quantity: Quantity,
    pub(super) origin: Origin,
    pub(super) unit: NamedUnit,
}

impl Name {
    pub(super) fn parse(text: &str) -> Self {
        let text = text.trim().trim_start_matches(['%', '#']).trim();
        let (base, bracket) = split_bracket(text);
        let words = words(base);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let (unit, is_rate, own) = match bracket {
            Some(inside) => {
                let (unit, is_rate) = bracket_unit(inside);
                (unit, is_rate, &words[..])
            }
            None => last_unit(&words),
        };
        let quantity = if is_rate {
            Quantity::Speed
        } else {
            quantity(text, own, &unit)
        };
        Self {
            text: text.to_owned(),
            quantity,
            origin: origin(own),
            unit,
        }
    }
}

/// `x [mm]`, `x (mm)`: what stands in front, and what stands inside. An index such as `position[0]` stays with the name.
fn split_bracket(text: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some((base, inside)) = text
            .strip_suffix(close)
            .and_then(|rest| rest.rsplit_once(open))
        {
            let is_index = inside.bytes().all(|byte| byte.is_ascii_digit());
            return (base, (!is_index).then_some(inside));
        }
    }
    (text, None)
}

/// Lower-case words; a change from a small to a capital letter begins one, as in `timeMs`, but not behind the prefix of a unit,
/// as in `mDeg`.
fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before_is_small = false;
    for letter in text.chars() {
        // What was no UTF-8 is part of a word: `\u{fffd}s` is no second.
        let is_part = letter.is_alphanumeric() || matches!(letter, '°' | '%' | '\u{fffd}');
        let is_prefix = words
            .last()
            .is_some_and(|word| PREFIXES.contains(&word.as_str()));
        let begins = letter.is_uppercase() && before_is_small && !is_prefix;
        if (!is_part || begins) && words.last().is_some_and(|word| !word.is_empty()) {
            words.push(String::new());
        }
        if is_part && let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
        before_is_small = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Prefixes of units in which nothing is read, and of those of time, which are.
const PREFIXES: [&str; 8] = ["m", "u", "µ", "μ", "n", "k", "c", "p"];

/// A word without the number behind it, as in `q1`.
fn stem(word: &str) -> &str {
    let stem = word.trim_end_matches(|letter: char| letter.is_ascii_digit());
    if stem.is_empty() { word } else { stem }
}

fn position_unit(word: &str) -> Option<Unit> {
    Some(match word {
        "deg" | "degs" | "degree" | "degrees" | "°" => Unit::Degrees,
        "rad" | "rads" | "radian" | "radians" => Unit::Radians,
        "turn" | "turns" | "rev" | "revs" | "revolution" | "revolutions" => Unit::Turns,
        "count" | "counts" | "cts" | "cnt" => Unit::Counts,
        "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => Unit::Mm,
        _ => return None,
    })
}

fn time_unit(word: &str) -> Option<TimeUnit> {
    Some(match word {
        "s" | "sec" | "secs" | "second" | "seconds" => TimeUnit::S,
        "sekunde" | "sekunden" => TimeUnit::S,
        "ms" | "msec" | "msecs" | "millis" | "millisec" | "millisecs" | "millisecond"
        | "milliseconds" | "millisekunde" | "millisekunden" => TimeUnit::Ms,
        "us" | "µs" | "μs" | "usec" | "usecs" | "micros" | "microsec" | "microsecs"
        | "microsecond" | "microseconds" | "mikrosekunde" | "mikrosekunden" => TimeUnit::Us,
        "ns" | "nsec" | "nsecs" | "nanos" | "nanosec" | "nanosecs" | "nanosecond"
        | "nanoseconds" | "nanosekunde" | "nanosekunden" => TimeUnit::Ns,
        _ => return None,
    })
}

/// A unit with a prefix, as `mdeg`, in which nothing is read.
fn has_prefix(word: &str) -> bool {
    let rest = PREFIXES.iter().find_map(|prefix| word.strip_prefix(prefix));
    rest.is_some_and(|rest| position_unit(rest).is_some() || time_unit(rest).is_some())
}

/// A unit in brackets is one, known or not; the second value says whether it is one of a speed or an acceleration.
fn bracket_unit(inside: &str) -> (NamedUnit, bool) {
    let parts = words(inside);
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    match parts[..] {
        [one] => match (position_unit(one), time_unit(one)) {
            (Some(unit), _) => (NamedUnit::Position(unit), false),
            (_, Some(unit)) => (NamedUnit::Time(unit), false),
            _ if is_rpm(&parts) => (NamedUnit::Position(Unit::Rpm), true),
            _ => (NamedUnit::Foreign(inside.to_owned()), is_rate(&parts)),
        },
        _ if is_rpm(&parts) => (NamedUnit::Position(Unit::Rpm), true),
        _ => (NamedUnit::Foreign(inside.to_owned()), is_rate(&parts)),
    }
}

/// The unit at the end of a name with underscores, whether it is one of a speed, and the words in front of it.
fn last_unit<'a, 'b>(words: &'a [&'b str]) -> (NamedUnit, bool, &'a [&'b str]) {
    let numbers = words
        .iter()
        .rev()
        .take_while(|word| word.bytes().all(|byte| byte.is_ascii_digit()));
    let end = words.len() - numbers.count();
    let named = &words[..end];
    if is_rpm(named) {
        return (NamedUnit::Position(Unit::Rpm), true, named);
    }
    if is_rate(named) {
        // `deg/s`, or one word such as `mps`.
        let words = if is_rate(&named[named.len() - 1..]) {
            1
        } else {
            2
        };
        let unit = named[named.len().saturating_sub(words)..].join("/");
        return (NamedUnit::Foreign(unit), true, named);
    }
    let Some((&last, front)) = named.split_last() else {
        return (NamedUnit::Unsaid, false, words);
    };
    if let Some(unit) = time_unit(last) {
        return (NamedUnit::Time(unit), false, front);
    }
    if let Some(unit) = position_unit(last) {
        return (NamedUnit::Position(unit), false, front);
    }
    // A unit with a factor, such as 100ns.
    let behind_digits = last.trim_start_matches(|letter: char| letter.is_ascii_digit());
    let has_factor = behind_digits.len() < last.len()
        && (time_unit(behind_digits).is_some() || position_unit(behind_digits).is_some());
    // One or two letters alone name an axis.
    let is_foreign = FOREIGN.contains(&last) && (!front.is_empty() || last.chars().count() > 2);
    if has_prefix(last) || is_foreign || (has_factor && !front.is_empty()) {
        return (NamedUnit::Foreign(last.to_owned()), false, front);
    }
    (NamedUnit::Unsaid, false, words)
}

/// `rpm`, `r/min`, `1/min`, `U/min`, `rev/min`.
fn is_rpm(words: &[&str]) -> bool {
    match words {
        [.., last] if stem(last) == "rpm" => true,
        [.., "r" | "u" | "1" | "rev", "min"] => true,
        _ => false,
    }
}

/// `rpm`, `deg/s`, `rad_per_s`, `mm/s^2`, `1/min`, ...
fn is_rate(words: &[&str]) -> bool {
    let mut words = words;
    if let [front @ .., "2" | "²"] = words {
        words = front;
    }
    let Some((last, front)) = words.split_last() else {
        return false;
    };
    if matches!(
        stem(last),
        "rpm" | "rps" | "dps" | "degps" | "radps" | "mps" | "mmps" | "kmh" | "kph" | "hz"
    ) {
        return true;
    }
    let is_time = matches!(*last, "s" | "sec" | "s2" | "s²" | "min" | "sec2" | "h");
    let is_length = |word: &str| {
        position_unit(word).is_some()
            || matches!(word, "m" | "cm" | "in" | "inc" | "r" | "u" | "1" | "per")
    };
    is_time && front.last().is_some_and(|before| is_length(before))
}

fn quantity(text: &str, words: &[&str], unit: &NamedUnit) -> Quantity {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&stem(word)));
    if text.is_empty() {
        return Quantity::Other("no name");
    }
    if has(ACCELERATIONS) {
        return Quantity::Other("an acceleration");
    }
    // `xdot`, `dx/dt`, `x'`
    let is_derivative = words
        .iter()
        .any(|word| stem(word).ends_with("dot") || *word == "dt");
    if has(SPEEDS) || (is_derivative && words.len() > 1) || text.contains(['\'', '′']) {
        return Quantity::Speed;
    }
    if is_derivative {
        return match words {
            ["dt"] => Quantity::Other("a time that is not the time column"),
            _ => Quantity::Speed,
        };
    }
    if has(FORCES) {
        return Quantity::Other("a force or torque");
    }
    if has(DEVIATIONS) {
        return Quantity::Other("a deviation or age");
    }
    if has(TIMES) || words == ["t"] || (words.is_empty() && matches!(unit, NamedUnit::Time(_))) {
        return if is_qualified(words, TIMES, |word| BEHIND_TIME.contains(&word)) {
            Quantity::Other("a time that is not the time column")
        } else {
            Quantity::Time
        };
    }
    if matches!(unit, NamedUnit::Time(_)) {
        return Quantity::Other("a time that is not the time column");
    }
    // What an encoder counts is a position in a unit of its own.
    if has(&["encoder"]) && !matches!(unit, NamedUnit::Position(_)) {
        return Quantity::Unclear;
    }
    if has(POSITIONS) {
        return if is_qualified(words, POSITIONS, names_axis) {
            Quantity::Unclear
        } else {
            Quantity::Position
        };
    }
    if has(ELECTRICAL) {
        return Quantity::Other("an electrical value");
    }
    if has(STATES) {
        return Quantity::Other("a state or a text");
    }
    if is_counter(words) {
        return Quantity::Other("a counter");
    }
    if is_unclear(words) {
        return Quantity::Unclear;
    }
    match words {
        // The unit alone, as in `deg`.
        [] => Quantity::Unnamed,
        _ if words.iter().all(|word| is_number(word)) => Quantity::Unknown,
        _ if words.iter().all(|word| names_axis(word)) => Quantity::Unnamed,
        // A unit of positions says enough of one word, as in `d_turns`.
        [_] if matches!(unit, NamedUnit::Position(_)) => Quantity::Unnamed,
        [_] => Quantity::Unknown,
        _ => Quantity::Unclear,
    }
}

/// Whether a word that is not known stands behind the last of the listed ones, as in `pos_filtered` and `time_cycles`: nobody
/// knows what it makes of them.
fn is_qualified(words: &[&str], list: &[&str], is_known: impl Fn(&str) -> bool) -> bool {
    let last = words.iter().rposition(|word| list.contains(&stem(word)));
    let behind = last.map_or(&[][..], |last| &words[last + 1..]);
    behind
        .iter()
        .any(|word| !is_number(word) && !is_known(word))
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a word names an axis: its letter, its part of a machine, or whose value it is.
fn names_axis(word: &str) -> bool {
    let stem = stem(word);
    is_number(word)
        || [AXES, COMMANDED, MEASURED]
            .iter()
            .any(|list| list.contains(&stem))
}

/// `row`, `sample 3`, `header.seq`: a word for a counter alone, with a number, or at the end of a name when it means nothing else.
fn is_counter(words: &[&str]) -> bool {
    match words {
        [.., "seq" | "index" | "idx"] => true,
        [first, rest @ ..] => COUNTERS.contains(first) && rest.iter().all(|word| is_number(word)),
        [] => false,
    }
}

/// Letters of physics that also name axes: `v`, `wz`, `dx`, `ay`, `j1_v`, and two of them, as `a_x`; `n` and `k` alone count.
fn is_unclear(words: &[&str]) -> bool {
    let is_single = |word: &&&str| stem(word).chars().count() == 1 && !is_number(word);
    if words.iter().filter(is_single).count() > 1 {
        return true;
    }
    let is_letter = |word: &&str| {
        let mut letters = stem(word).chars();
        match (letters.next(), letters.next(), letters.next()) {
            (Some('v' | 'w' | 'i'), None, _) => true,
            (Some('v' | 'w' | 'a' | 'g' | 'f' | 'm'), Some('x' | 'y' | 'z'), None) => true,
            (Some('d'), Some(letter), None) => letter.is_alphabetic(),
            _ => false,
        }
    };
    words.iter().any(is_letter) || matches!(words, [word] if matches!(stem(word), "k" | "n"))
}

fn origin(words: &[&str]) -> Origin {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&stem(word)));
    if has(COMMANDED) {
        Origin::Commanded
    } else if has(MEASURED) {
        Origin::Measured
    } else {
        Origin::Unsaid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> (Quantity, NamedUnit) {
        let name = Name::parse(text);
        (name.quantity, name.unit)
    }

    #[test]
    fn times() {
        use NamedUnit::{Time, Unsaid};
        for (text, unit) in [
            ("t", Unsaid),
            ("Time", Unsaid),
            ("%time", Unsaid),
            ("time_s", Time(TimeUnit::S)),
            ("time_ms", Time(TimeUnit::Ms)),
            ("timeMs", Time(TimeUnit::Ms)),
            ("t [us]", Time(TimeUnit::Us)),
            ("Time (ns)", Time(TimeUnit::Ns)),
            ("t/s", Time(TimeUnit::S)),
            ("time_from_start", Unsaid),
            ("seconds", Time(TimeUnit::S)),
            ("field.header.stamp", Unsaid),
            ("time_mS", Time(TimeUnit::Ms)),
            ("time_µS", Time(TimeUnit::Us)),
            ("time_nS", Time(TimeUnit::Ns)),
            ("t [mSec]", Time(TimeUnit::Ms)),
            ("time_nanosec", Time(TimeUnit::Ns)),
            ("Zeit_Millisekunden", Time(TimeUnit::Ms)),
            ("time_ps", NamedUnit::Foreign("ps".into())),
            ("t [\u{fffd}s]", NamedUnit::Foreign("\u{fffd}s".into())),
            ("time_min", NamedUnit::Foreign("min".into())),
            ("time_100ns", NamedUnit::Foreign("100ns".into())),
        ] {
            assert_eq!(parse(text), (Quantity::Time, unit), "{text}");
        }
    }

    #[test]
    fn positions_and_their_units() {
        use NamedUnit::{Foreign, Position, Unsaid};
        for (text, quantity, unit) in [
            ("pos", Quantity::Position, Unsaid),
            ("q1", Quantity::Position, Unsaid),
            ("position[0]", Quantity::Position, Unsaid),
            ("/arm/joint1/position", Quantity::Position, Unsaid),
            ("shoulder", Quantity::Unnamed, Unsaid),
            ("joint1", Quantity::Unnamed, Unsaid),
            ("a", Quantity::Unnamed, Unsaid),
            ("x_mm", Quantity::Unnamed, Position(Unit::Mm)),
            ("a_rad", Quantity::Unnamed, Position(Unit::Radians)),
            ("x [mm]", Quantity::Unnamed, Position(Unit::Mm)),
            ("angle (°)", Quantity::Position, Position(Unit::Degrees)),
            ("posDeg", Quantity::Position, Position(Unit::Degrees)),
            ("q_rad_1", Quantity::Position, Position(Unit::Radians)),
            ("x/mm", Quantity::Unnamed, Position(Unit::Mm)),
            ("axis_turns", Quantity::Unnamed, Position(Unit::Turns)),
            (
                "axis0_target_counts",
                Quantity::Unnamed,
                Position(Unit::Counts),
            ),
            ("x_m", Quantity::Unnamed, Foreign("m".into())),
            ("e_counts", Quantity::Unnamed, Position(Unit::Counts)),
            ("e", Quantity::Unknown, Unsaid),
            ("m", Quantity::Unnamed, Unsaid),
            ("ticks", Quantity::Unnamed, Foreign("ticks".into())),
            ("x_meters", Quantity::Unnamed, Foreign("meters".into())),
            ("encoder_pos", Quantity::Unclear, Unsaid),
            ("encoder_deg", Quantity::Unnamed, Position(Unit::Degrees)),
            ("e_f_counts", Quantity::Unclear, Position(Unit::Counts)),
            ("x_mDeg", Quantity::Unnamed, Foreign("mdeg".into())),
            ("x_mRad", Quantity::Unnamed, Foreign("mrad".into())),
            ("uDeg", Quantity::Unnamed, Foreign("udeg".into())),
            ("q_kcounts", Quantity::Position, Foreign("kcounts".into())),
            ("x [V]", Quantity::Unnamed, Foreign("V".into())),
        ] {
            assert_eq!(parse(text), (quantity, unit), "{text}");
        }
    }

    #[test]
    fn what_is_no_position() {
        for text in [
            "vel",
            "joint1_velocity",
            "qd1",
            "dq2",
            "velocity[3]",
            "left_rpm",
            "x [deg/s]",
            "x_deg_s",
            "a (mm/s)",
            "qDot",
            "xdot1",
            "dx/dt",
            "x'",
            "left_mps",
        ] {
            assert_eq!(parse(text).0, Quantity::Speed, "{text}");
        }
        for text in [
            "",
            "acc",
            "qdd1",
            "effort[0]",
            "tau",
            "x_error",
            "Unnamed: 0",
            "index",
            "row",
            "sample 3",
            "name",
            "status_age_us",
            "header.seq",
        ] {
            assert!(matches!(parse(text).0, Quantity::Other(_)), "{text}");
        }
        for text in ["v", "v1", "wz", "i", "dx", "ay", "j1_v", "v_2", "fz"] {
            assert_eq!(parse(text).0, Quantity::Unclear, "{text}");
        }
    }

    #[test]
    fn where_values_come_from() {
        assert_eq!(Name::parse("target_pos").origin, Origin::Commanded);
        assert_eq!(Name::parse("actual position").origin, Origin::Measured);
        assert_eq!(Name::parse("shoulder").origin, Origin::Unsaid);
    }
}
