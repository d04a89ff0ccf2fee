//! Where the instructions of one axis of the master alone go, by function: the images of `cargo xtask cost --only hot-path`.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

use crate::calls::{CALLS, TWICE};
use crate::cost::{EIGHT_AXES, FEWER_AXES, HOT_PATH, ONE_AXIS};
use crate::emulator::Emulator;
use crate::error::Error;
use crate::thumb::{Builder, Variant};

/// Instructions are told in tenths.
const PARTS: i64 = 10;

/// The table: what a cycle of eight axes takes more than one of one axis, by seven.
///
/// # Errors
/// When an image does not build or the emulator fails.
pub(crate) fn table(builder: &Builder, emulator: &Emulator, rows: usize) -> Result<String, Error> {
    let mut functions = BTreeMap::new();
    for (features, sign) in [(None, -1), (Some(TWICE), 1)] {
        let features = features.into_iter().flat_map(|name| ["--features", name]);
        let arguments = ["--bin", ONE_AXIS, "--bin", EIGHT_AXES]
            .into_iter()
            .chain(features);
        let arguments: Vec<String> = arguments.map(str::to_owned).collect();
        builder.build(HOT_PATH, &Variant::with_arguments(&arguments))?;
        for (image, sign) in [(ONE_AXIS, -sign), (EIGHT_AXES, sign)] {
            let counted = emulator.count_by_function(&builder.images().join(image))?;
            add(&mut functions, &counted, sign).ok_or_else(|| Error::Answer {
                program: "the emulator's program `count`".into(),
                expected: "instructions by function",
            })?;
        }
    }
    Ok(write(&functions, (CALLS * FEWER_AXES) as i64, rows))
}

/// `None` when something is missing.
fn add(functions: &mut BTreeMap<String, i64>, counted: &Value, sign: i64) -> Option<()> {
    for entry in counted["functions"].as_array()? {
        let (function, file) = (entry["function"].as_str()?, entry["file"].as_str()?);
        let instructions = i64::try_from(entry["instructions"].as_u64()?).ok()?;
        *functions.entry(format!("{function}  {file}")).or_default() += sign * instructions;
    }
    Some(())
}

/// The largest first. A function whose code is another one in the image of one axis may have less than nothing.
fn write(functions: &BTreeMap<String, i64>, axis_cycles: i64, rows: usize) -> String {
    let mut lines: Vec<(&str, i64)> = functions
        .iter()
        .map(|(name, count)| (&**name, *count))
        .filter(|(_, count)| *count != 0)
        .collect();
    lines.sort_by_key(|&(name, count)| (-count, name));
    let rest = lines.split_off(rows.min(lines.len()));
    let others = format!("{} other functions", rest.len());
    if !rest.is_empty() {
        lines.push((&others, rest.iter().map(|(_, count)| count).sum()));
    }
    let counts: Vec<i64> = lines.iter().map(|(_, count)| *count).collect();
    let parts = apportion(&counts, axis_cycles);
    let mut text = format!("{:>12}  function\n", "instructions");
    let mut line = |tenths: i64, name: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:>12.1}  {name}", tenths as f64 / PARTS as f64);
    };
    for (part, (name, _)) in parts.iter().zip(&lines) {
        line(*part, name);
    }
    line(parts.iter().sum(), "all: one axis in one cycle");
    text
}

/// Tenths of each count by `of`, rounded so that they add up to the rounded sum.
fn apportion(counts: &[i64], of: i64) -> Vec<i64> {
    let total = (2 * PARTS * counts.iter().sum::<i64>() + of).div_euclid(2 * of);
    let mut parts: Vec<i64> = counts
        .iter()
        .map(|count| (PARTS * count).div_euclid(of))
        .collect();
    let mut by_remainder: Vec<usize> = (0..counts.len()).collect();
    by_remainder.sort_by_key(|&place| -(PARTS * counts[place]).rem_euclid(of));
    let missing = total - parts.iter().sum::<i64>();
    for &place in by_remainder
        .iter()
        .take(usize::try_from(missing).unwrap_or(0))
    {
        parts[place] += 1;
    }
    parts
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_lines_add_up_to_the_axis_also_when_one_has_less_than_nothing() {
        let counted = |a: u64, b: u64, c: u64| {
            json!({"functions": [
                {"function": "a", "file": "a.rs", "instructions": a},
                {"function": "b", "file": "b.rs", "instructions": b},
                {"function": "c", "file": "c.rs", "instructions": c},
            ]})
        };
        let mut functions = BTreeMap::new();
        add(&mut functions, &counted(1_000, 30, 60), 1).unwrap();
        add(&mut functions, &counted(100, 51, 11), -1).unwrap();
        for rows in [1, 2, 40] {
            let text = write(&functions, 7, rows);
            let tenths = |line: &str| {
                let figure = line.split_whitespace().next().unwrap();
                (figure.parse::<f64>().unwrap() * 10.0).round() as i64
            };
            let mut lines: Vec<i64> = text.lines().skip(1).map(tenths).collect();
            // 928 / 7
            assert_eq!(lines.pop(), Some(1_326), "{text}");
            assert_eq!(lines.iter().sum::<i64>(), 1_326, "{text}");
        }
    }

    #[test]
    fn an_answer_without_functions_is_refused() {
        assert!(add(&mut BTreeMap::new(), &json!(7), 1).is_none());
    }
}
