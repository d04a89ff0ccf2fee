//! Whether a name in a cell names something: an item of a crate, a call of the tool, a file, an object with its address.

use std::collections::BTreeMap;

use crate::Code;
use crate::answer::{Answer, Name, answer};
use crate::page::{Cell, Complaint};
use crate::sources::{Found, Syntax};

/// The crates that a column may name.
pub(crate) const CODEC: &[&str] = &[
    "can_frame",
    "dyn_can",
    "dyn_serial",
    "dyn_values",
    "zlac8030l",
];
/// The master, and what is used beside it on the bus.
pub(crate) const MASTER: &[&str] = &[
    "bus_plan",
    "bus_user",
    "can_motion",
    "dyn_commission",
    "homing",
];
pub(crate) const SIMULATOR: &[&str] = &["drive_sim"];
pub(crate) const FIRMWARE: &[&str] = &["motion_board"];
pub(crate) const EVERY: &[&str] = &[
    "can_frame",
    "dyn_can",
    "dyn_serial",
    "dyn_values",
    "zlac8030l",
    "bus_plan",
    "bus_user",
    "can_motion",
    "dyn_commission",
    "homing",
    "drive_sim",
    "motion_board",
];
/// Names that a message offers in place of a wrong one.
const MOST_HINTS: usize = 3;

/// Crates whose items a user of the project calls, so that a name must be public.
const PUBLIC: &[&str] = &[
    "can_frame",
    "dyn_can",
    "dyn_serial",
    "dyn_values",
    "zlac8030l",
    "bus_plan",
    "bus_user",
    "can_motion",
    "dyn_commission",
    "homing",
];

/// A name of any kind.
pub(crate) fn check_any(name: &Name<'_>, code: &Code) -> Result<(), Complaint> {
    if name.text.starts_with("motionctl ") {
        return check_command(name, code);
    }
    if name.text.contains("::") {
        return check_item(name, EVERY, code);
    }
    if name.text.contains(['/', '.']) {
        let exists = code.top.join(name.text).exists();
        return match exists {
            true => Ok(()),
            false => Err(Complaint::new(
                name.place,
                format!(
                    "expected a file of the repository, found {}, which is not there",
                    name.text
                ),
            )),
        };
    }
    Err(Complaint::new(
        name.place,
        format!(
            "expected crate::path, `motionctl command` or a file, found {}",
            name.text
        ),
    ))
}

/// A call of the tool.
pub(crate) fn check_command(name: &Name<'_>, code: &Code) -> Result<(), Complaint> {
    if !name.text.starts_with("motionctl ") {
        let text = format!("expected `motionctl command`, found {}", name.text);
        return Err(Complaint::new(name.place, text));
    }
    let called = code.tool.check_call(name.text);
    called.map_err(|text| Complaint::new(name.place, text))
}

/// An item of one of these crates.
pub(crate) fn check_item(name: &Name<'_>, crates: &[&str], code: &Code) -> Result<(), Complaint> {
    let path: Vec<&str> = name.text.split("::").collect();
    let wrong = |text: String| Err(Complaint::new(name.place, text));
    let Some((first, rest)) = path.split_first() else {
        return wrong("expected crate::path".to_owned());
    };
    let source = code.crates.get(first).filter(|_| crates.contains(first));
    let (Some(source), false) = (source, rest.is_empty()) else {
        return wrong(format!(
            "expected an item of {} in this column, found {}",
            crates.join(", "),
            name.text
        ));
    };
    match source.find(rest) {
        Found::Public => Ok(()),
        Found::Private if !PUBLIC.contains(first) => Ok(()),
        Found::Private => wrong(format!(
            "expected a public item, found {}, which only the crate itself can use",
            name.text
        )),
        Found::Nothing => {
            let like = code.crates.iter().flat_map(|(name, items)| {
                let items = items.like(rest).into_iter();
                items.map(move |item| format!("{name} has {item}"))
            });
            let like: Vec<String> = like.take(MOST_HINTS).collect();
            let hint = match like.is_empty() {
                true => "correct the path, or write `not yet`".to_owned(),
                false => like.join(", "),
            };
            wrong(format!(
                "expected an item that exists, found {}: {hint}",
                name.text
            ))
        }
    }
}

/// A typed object in the column of the codec has the address of its row.
pub(crate) fn check_typed_object(
    key: &Cell<'_>,
    codec: &Cell<'_>,
    code: &Code,
    complaints: &mut Vec<Complaint>,
) {
    let Ok(Answer::Here(names)) = answer(codec) else {
        return;
    };
    for name in names {
        let Some(constant) = name.text.strip_prefix("zlac8030l::objects::") else {
            continue;
        };
        if let Some(address) = code.typed_objects.get(constant)
            && *address != key.text
        {
            let text = format!(
                "expected an object at {}, found {constant}, which is {address}",
                key.text
            );
            complaints.push(Complaint::new(name.place, text));
        }
    }
    for (constant, address) in &code.typed_objects {
        if *address == key.text && !codec.text.contains(constant.as_str()) {
            let text = format!(
                "expected `zlac8030l::objects::{constant}` for {address}, found {}",
                codec.text
            );
            complaints.push(Complaint::new(codec.place, text));
        }
    }
}

/// The constants of `zlac8030l::objects` with their addresses, from `NAME: type = index, sub;`.
pub(crate) fn typed_objects(syntax: &Syntax) -> BTreeMap<String, String> {
    let mut typed = BTreeMap::new();
    for (modules, tokens) in &syntax.macro_calls {
        if modules != &["objects"] {
            continue;
        }
        let words: Vec<String> = tokens
            .clone()
            .into_iter()
            .map(|token| token.to_string())
            .collect();
        for window in words.windows(8) {
            if let [name, colon, _, equals, index, comma, sub, end] = window
                && (
                    colon.as_str(),
                    equals.as_str(),
                    comma.as_str(),
                    end.as_str(),
                ) == (":", "=", ",", ";")
                && let (Some(index), Some(sub)) = (number(index), number(sub))
            {
                typed.insert(name.clone(), format!("{index:04X}h:{sub:02X}"));
            }
        }
    }
    assert!(
        typed.len() > 30,
        "only {} typed objects found: crates/zlac8030l/src/objects.rs has another form",
        typed.len()
    );
    typed
}

fn number(text: &str) -> Option<u16> {
    match text.strip_prefix("0x") {
        Some(digits) => u16::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}
