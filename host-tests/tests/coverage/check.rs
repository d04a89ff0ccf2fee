//! Compares the page with what must be on it, and its names with what exists.

use std::collections::BTreeMap;

use crate::Code;
use crate::answer::{Answer, answer};
use crate::names::{
    CODEC, FIRMWARE, MASTER, SIMULATOR, check_any, check_command, check_item, check_typed_object,
};
use crate::page::{Cell, Complaint, Place, Table, tables};
use crate::required::{Answers, Expected, Required, objects_of, required};

/// The layers, as the columns of the page name them.
const LAYERS: [&str; 5] = ["Codec", "Master", "Simulator", "Tool", "Firmware"];
const WHERE_AND_MISSING: [&str; 2] = ["Where", "Missing"];
const OBJECTS: &str = "ZLAC8030L: objects";

/// Everything that is wrong with the text of the page, in its order.
pub(crate) fn check(text: &str, code: &Code) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let tables = tables(text, &mut complaints);
    let required = required();
    for wanted in &required {
        match tables.iter().find(|table| table.heading == wanted.heading) {
            Some(table) => check_table(table, wanted, code, &mut complaints),
            None => complaints.push(Complaint::new(
                Place { line: 1, column: 1 },
                format!(
                    "expected a table under the heading \"## {}\", found none",
                    wanted.heading
                ),
            )),
        }
    }
    for table in &tables {
        if !required
            .iter()
            .any(|wanted| wanted.heading == table.heading)
        {
            let text = format!(
                "found a table under \"{}\", which no check knows: add it to required()",
                table.heading
            );
            complaints.push(Complaint::new(table.place, text));
        }
    }
    complaints.sort();
    complaints.dedup();
    complaints
}

fn check_table(table: &Table<'_>, wanted: &Required, code: &Code, complaints: &mut Vec<Complaint>) {
    let answers: &[&str] = match wanted.answers {
        Answers::Layers => &LAYERS,
        Answers::WhereAndMissing => &WHERE_AND_MISSING,
    };
    let expected: Vec<&str> = wanted.keys.iter().chain(answers).copied().collect();
    let actual: Vec<&str> = table.columns.iter().map(|cell| cell.text).collect();
    if expected != actual {
        let text = format!("expected the columns {expected:?}, found {actual:?}");
        complaints.push(Complaint::new(table.place, text));
        return;
    }
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for row in &table.rows {
        let (keys, cells) = row.split_at(wanted.keys.len());
        let of_row = check_keys(keys, wanted, &mut seen, complaints);
        match wanted.answers {
            Answers::Layers => check_layers(cells, &of_row, code, complaints),
            Answers::WhereAndMissing => check_chapter(cells, code, complaints),
        }
        if wanted.heading == OBJECTS {
            check_typed_object(&keys[0], &cells[0], code, complaints);
        }
    }
    for row in wanted
        .rows
        .iter()
        .filter(|row| !seen.contains_key(&row.key))
    {
        let known = row.others.iter().flatten().map(String::as_str);
        let words: Vec<&str> = [row.key.as_str()].into_iter().chain(known).collect();
        let text = format!(
            "expected a row for {} under \"{}\", found none: say where it is, `not yet`, or `no: reason`",
            words.join(" "),
            wanted.heading
        );
        complaints.push(Complaint::new(table.place, text));
    }
}

/// The expected rows that a row of the page stands for.
fn check_keys<'a>(
    keys: &[Cell<'_>],
    wanted: &'a Required,
    seen: &mut BTreeMap<String, usize>,
    complaints: &mut Vec<Complaint>,
) -> Vec<&'a Expected> {
    let (key, others) = keys.split_first().expect("a first column");
    let named = match wanted.heading == OBJECTS {
        false => vec![key.text.to_owned()],
        true => objects_of(key.text).unwrap_or_else(|| {
            let text = format!(
                "expected an object such as 1017h:00 or 1400h-1403h:02-05, found \"{}\"",
                key.text
            );
            complaints.push(Complaint::new(key.place, text));
            Vec::new()
        }),
    };
    let is_range = named.len() > 1;
    let mut found = Vec::new();
    for name in named {
        let Some(row) = wanted.rows.iter().find(|row| row.key == name) else {
            let text = format!(
                "found {name}, which does not exist under \"{}\": remove it, or correct it",
                wanted.heading
            );
            complaints.push(Complaint::new(key.place, text));
            continue;
        };
        if let Some(line) = seen.insert(name.clone(), key.place.line) {
            let text = format!("found {name} a second time, it is in line {line}: keep one row");
            complaints.push(Complaint::new(key.place, text));
        }
        for (expected, actual) in row.others.iter().zip(others) {
            check_word(expected.as_deref(), actual, is_range, complaints);
        }
        found.push(row);
    }
    found
}

/// In a row that stands for several objects each number of a name is n.
fn check_word(
    expected: Option<&str>,
    actual: &Cell<'_>,
    is_range: bool,
    complaints: &mut Vec<Complaint>,
) {
    let matches = match expected {
        None => !actual.text.is_empty(),
        Some(expected) if is_range => without_numbers(expected) == actual.text,
        Some(expected) => expected == actual.text,
    };
    if !matches {
        let expected = match expected {
            None => "some words".to_owned(),
            Some(name) if is_range => format!("\"{}\"", without_numbers(name)),
            Some(name) => format!("\"{name}\""),
        };
        let text = format!("expected {expected}, found \"{}\"", actual.text);
        complaints.push(Complaint::new(actual.place, text));
    }
}

fn without_numbers(name: &str) -> String {
    let mut text = String::new();
    let mut is_in_number = false;
    for letter in name.chars() {
        let is_digit = letter.is_ascii_digit();
        match is_digit {
            true if is_in_number => {}
            true => text.push('n'),
            false => text.push(letter),
        }
        is_in_number = is_digit;
    }
    text
}

fn check_layers(
    cells: &[Cell<'_>],
    rows: &[&Expected],
    code: &Code,
    complaints: &mut Vec<Complaint>,
) {
    let crates = [CODEC, MASTER, SIMULATOR, &[], FIRMWARE];
    for ((cell, layer), crates) in cells.iter().zip(LAYERS).zip(crates) {
        let names = match answer(cell) {
            Ok(Answer::Here(names)) => names,
            Ok(Answer::No) => Vec::new(),
            Ok(Answer::NotYet(words)) => {
                complaints.extend(check_planned(words, cell, code).err());
                Vec::new()
            }
            Err(complaint) => {
                complaints.push(complaint);
                continue;
            }
        };
        for name in &names {
            let result = match layer {
                "Tool" => check_command(name, code),
                _ => check_item(name, crates, code),
            };
            complaints.extend(result.err());
        }
        if layer != "Codec" {
            continue;
        }
        for row in rows {
            if let Some(message) = &row.codec
                && !(names.iter()).any(|name| name.text.rsplit("::").next() == Some(message))
            {
                let text = format!("expected a name that ends with ::{message}, as the code does");
                complaints.push(Complaint::new(cell.place, text));
            }
        }
    }
}

fn check_chapter(cells: &[Cell<'_>], code: &Code, complaints: &mut Vec<Complaint>) {
    let [place, missing] = cells else {
        return;
    };
    if place.text == "-" && missing.text == "-" {
        let text = "expected where it is, or what is missing, found neither";
        complaints.push(Complaint::new(place.place, text));
    }
    if missing.text != "-" {
        for part in missing.text.split("; ") {
            complaints.extend(check_missing(part, missing).err());
            complaints.extend(check_planned(part, missing, code).err());
        }
    }
    if place.text == "-" {
        return;
    }
    match answer(place) {
        Ok(Answer::Here(names)) => {
            for name in &names {
                complaints.extend(check_any(name, code).err());
            }
        }
        Ok(_) => {
            let text = format!(
                "expected `name`, `name` or -, found \"{}\": what is missing has a column of its own",
                place.text
            );
            complaints.push(Complaint::new(place.place, text));
        }
        Err(complaint) => complaints.push(complaint),
    }
}

/// Commands in backticks, up to the first semicolon, are planned: one that exists is not missing any more.
fn check_planned(words: &str, cell: &Cell<'_>, code: &Code) -> Result<(), Complaint> {
    let planned = words.split(';').next().unwrap_or_default();
    let in_backticks = planned.split('`').skip(1).step_by(2);
    let mut done = in_backticks.filter(|name| code.tool.has(name));
    match done.next() {
        None => Ok(()),
        Some(name) => Err(Complaint::new(
            cell.place,
            format!(
                "expected a command that is missing, found \"{name}\", which exists: name `motionctl {name}`, or say without backticks what is missing"
            ),
        )),
    }
}

/// `no: reason`, or `not yet: layer, layer (note)`.
fn check_missing(part: &str, cell: &Cell<'_>) -> Result<(), Complaint> {
    let is_right = if let Some(reason) = part.strip_prefix("no: ") {
        reason.len() > 3
    } else if let Some(rest) = part.strip_prefix("not yet: ") {
        let layers = rest.split(" (").next().unwrap_or_default();
        let is_layer = |word: &str| {
            LAYERS
                .iter()
                .any(|layer| layer.eq_ignore_ascii_case(word) && word != *layer)
        };
        layers.split(", ").all(is_layer)
    } else {
        false
    };
    match is_right {
        true => Ok(()),
        false => Err(Complaint::new(
            cell.place,
            format!(
                "expected -, \"no: reason\" or \"not yet: layer, layer (note)\" with layers of codec, master, simulator, tool, firmware, several behind \"; \", found \"{part}\""
            ),
        )),
    }
}
