//! Pages that are wrong in one way each, made of the real one: the check says what and where.

use crate::{CODE, page};

/// The page with a piece of text replaced once.
fn with(page: &str, from: &str, to: &str) -> String {
    assert!(
        page.contains(from),
        "the page has no \"{from}\" any more: choose another piece for this test"
    );
    page.replacen(from, to, 1)
}

/// The line of the page that starts so, with its end.
fn line<'a>(page: &'a str, start: &str) -> &'a str {
    page.split_inclusive('\n')
        .find(|line| line.starts_with(start))
        .unwrap_or_else(|| panic!("the page has no line \"{start}\" any more"))
}

fn without_line(page: &str, start: &str) -> String {
    with(page, line(page, start), "")
}

fn with_line_twice(page: &str, start: &str) -> String {
    let line = line(page, start);
    with(page, line, &format!("{line}{line}"))
}

/// Each broken page, with a part of the complaint.
fn check_all(cases: &[(&str, String, &str)]) {
    for (what, text, expected) in cases {
        let complaints = CODE.complaints(text);
        assert!(
            complaints
                .iter()
                .any(|complaint| complaint.text.contains(expected)),
            "{what}: expected a complaint with \"{expected}\", found {complaints:#?}"
        );
    }
}

#[test]
fn what_has_no_row_is_named() {
    let page = page();
    let fewer_subs = with(
        &page,
        "| 1600h-1603h:01-04 | RPDOn mapping",
        "| 1600h-1603h:01-03 | RPDOn mapping",
    );
    for index in ["1600h:04", "1601h:04", "1602h:04", "1603h:04"] {
        let expected = format!("expected a row for {index} RPDO");
        check_all(&[("a range is too short", fewer_subs.clone(), &expected)]);
    }
    check_all(&[
        (
            "a function code",
            without_line(&page, "| 0x1C | Go_Relative_Pos_PD"),
            "expected a row for 0x1C Go_Relative_Pos_PD both under \"DYN CAN",
        ),
        (
            "a function of the host",
            without_line(&page, "| 0x17 | Set_GearNumber"),
            "expected a row for 0x17 Set_GearNumber under \"DYN232M: host",
        ),
        (
            "a function of the drive",
            without_line(&page, "| 0x18 | Is_GearNumber"),
            "expected a row for 0x18 Is_GearNumber under \"DYN232M: drive",
        ),
        (
            "a setting",
            without_line(&page, "| gear number |"),
            "expected a row for gear number",
        ),
        (
            "an object",
            without_line(&page, "| 603Fh:00 |"),
            "expected a row for 603Fh:00 last fault code",
        ),
        (
            "a section",
            without_line(&page, "| 7.2.6 |"),
            "expected a row for 7.2.6 under \"DYN2 manual A1.8\"",
        ),
        (
            "a table",
            with(&page, "## DYN2 manual A1.8", "## Another manual"),
            "expected a table under the heading \"## DYN2 manual A1.8\"",
        ),
        (
            "an unknown table",
            with(&page, "## DYN2 manual A1.8", "## Another manual"),
            "which no check knows",
        ),
    ]);
}

#[test]
fn what_is_there_twice_or_does_not_belong_is_named() {
    let page = page();
    check_all(&[
        (
            "a function code",
            with_line_twice(&page, "| 0x1C | Go_Relative_Pos_PD"),
            "found 0x1C a second time",
        ),
        (
            "an object",
            with_line_twice(&page, "| 603Fh:00 |"),
            "found 603Fh:00 a second time",
        ),
        (
            "two ranges overlap",
            with(&page, "| 1800h-1803h:03 |", "| 1800h-1803h:02-03 |"),
            "found 1800h:02 a second time",
        ),
        (
            "an object that is not in the dictionary",
            with(&page, "| 603Fh:00 |", "| 603Eh:00 |"),
            "found 603Eh:00, which does not exist",
        ),
        (
            "a range that leaves the dictionary",
            with(&page, "| 1400h-1403h:05 |", "| 1400h-1404h:05 |"),
            "found 1404h:05, which does not exist",
        ),
        (
            "an object in another form",
            with(&page, "| 603Fh:00 |", "| 603F:00 |"),
            "expected an object such as 1017h:00",
        ),
        (
            "another function",
            with(
                &page,
                "| 0x1C | Go_Relative_Pos_PD |",
                "| 0x1C | Go_Relative_Pos |",
            ),
            "expected \"Go_Relative_Pos_PD\", found \"Go_Relative_Pos\"",
        ),
        (
            "another revision",
            with(&page, "| Drive_Reset | 1.6A |", "| Drive_Reset | both |"),
            "expected \"1.6A\", found \"both\"",
        ),
        (
            "another object",
            with(
                &page,
                "| 6040h:00 | control word |",
                "| 6040h:00 | status word |",
            ),
            "expected \"control word\", found \"status word\"",
        ),
    ]);
}

#[test]
fn a_name_that_does_not_exist_is_named() {
    let page = page();
    let codec = "`dyn_can::Request::SetOrigin`";
    let master = "`can_motion::Procedure::SetOrigin`";
    let command = "`motionctl write main-gain`";
    check_all(&[
        (
            "an item",
            with(&page, codec, "`dyn_can::Request::SetOrigins`"),
            "found dyn_can::Request::SetOrigins",
        ),
        (
            "an item that only a comment or a string has",
            with(&page, codec, "`dyn_can::Request::Set_Origin`"),
            "found dyn_can::Request::Set_Origin",
        ),
        (
            "an item of another module",
            with(&page, codec, "`dyn_can::reply::Request::SetOrigin`"),
            "expected an item that exists",
        ),
        (
            "the codec of another function",
            with(&page, codec, "`dyn_can::Request::DriveReset`"),
            "expected a name that ends with ::SetOrigin",
        ),
        (
            "an item that another crate has",
            with(&page, master, "`can_motion::commission::AssignId`"),
            "found can_motion::commission::AssignId: dyn_commission has AssignId",
        ),
        (
            "an item of the wrong crate",
            with(&page, master, "`dyn_can::Request::SetOrigin`"),
            "expected an item of bus_plan, bus_user, can_motion, dyn_commission, homing in this column",
        ),
        (
            "an item that cannot be used from outside",
            with(&page, master, "`can_motion::Procedure::writes`"),
            "expected a public item",
        ),
        (
            "a typed object of another row",
            with(
                &page,
                "`zlac8030l::objects::CONTROL_WORD`",
                "`zlac8030l::objects::STATUS_WORD`",
            ),
            "expected an object at 6040h:00, found STATUS_WORD, which is 6041h:00",
        ),
        (
            "a typed object that is not named",
            with(
                &page,
                "`zlac8030l::objects::CONTROL_WORD`",
                "`zlac8030l::dictionary`",
            ),
            "expected `zlac8030l::objects::CONTROL_WORD` for 6040h:00",
        ),
        (
            "a command",
            with(&page, command, "`motionctl scribble`"),
            "found \"scribble\"",
        ),
        (
            "an option",
            with(&page, command, "`motionctl write --main-gain`"),
            "found \"--main-gain\"",
        ),
        (
            "a value of an option",
            with(&page, "--protocol canopen`", "--protocol modbus`"),
            "expected one of [dyn, canopen] in motionctl scan, found \"modbus\"",
        ),
        (
            "a parameter",
            with(&page, command, "`motionctl write gain`"),
            "found \"gain\"",
        ),
        (
            "a command that is not missing any more",
            with(
                &page,
                "no: gains are tuned once, with the tool",
                "not yet (`jog`)",
            ),
            "found \"jog\", which exists",
        ),
        (
            "a file",
            with(&page, "`docs/plan.md`", "`docs/plans.md`"),
            "found docs/plans.md, which is not there",
        ),
    ]);
}

#[test]
fn a_cell_has_one_of_four_forms() {
    let page = page();
    let cell = "`can_motion::Procedure::SetOrigin`";
    let cases: Vec<(&str, String, &str)> = [
        ("", "expected an answer, found \"\""),
        ("yes", "expected an answer, found \"yes\""),
        (
            "can_motion::Procedure::SetOrigin",
            "expected an answer, found \"can_motion",
        ),
        ("no:", "expected a reason behind \"no: \""),
        ("not yet, soon", "expected nothing or (note)"),
        (
            "partly: `can_motion::Procedure::SetOrigin`",
            "expected (what is missing) behind \"partly:\"",
        ),
        (
            "`can_motion::Procedure::SetOrigin` and more",
            "expected \", `name`\" or \" (note)\"",
        ),
        ("a | b", "expected 8 cells, found 9"),
    ]
    .into_iter()
    .map(|(wrong, expected)| (wrong, with(&page, cell, wrong), expected))
    .collect();
    check_all(&cases);
    check_all(&[
        (
            "a row without an end",
            with(&page, "| 7.2.6 | checksum |", "| 7.2.6 | checksum").replace(
                "`dyn_serial::PacketError` | - |",
                "`dyn_serial::PacketError` | -",
            ),
            "expected | at the end of the row",
        ),
        (
            "an unknown layer",
            with(
                &page,
                "(a stop is a new target) | no: the tool waits",
                "(a stop is a new target) | not yet: tools; no: the tool waits",
            ),
            "found \"not yet: tools\"",
        ),
        (
            "nothing said of a section",
            with(
                &page,
                "| 2.1 | layout of the body | - | no: mechanics |",
                "| 2.1 | layout of the body | - | - |",
            ),
            "expected where it is, or what is missing",
        ),
        (
            "another column",
            with(
                &page,
                "| Code | Function | Codec |",
                "| Code | Function | Codecs |",
            ),
            "expected the columns",
        ),
    ]);
}

#[test]
fn a_complaint_has_line_and_column() {
    let page = page();
    let name = "`can_motion::Procedure::SetOrigin`";
    let (before, _) = page.split_once(name).expect("the name is there");
    let line = before.lines().count();
    let column = before.lines().last().map_or(0, |line| line.chars().count()) + 2;
    let text = with(&page, name, "`can_motion::Procedure::SetNothing`");
    let of_page = CODE.complaints(&page);
    let complaints = CODE.complaints(&text);
    let new: Vec<_> = (complaints.iter())
        .filter(|complaint| !of_page.contains(complaint))
        .collect();
    assert_eq!(new.len(), 1, "{new:#?}");
    assert_eq!((new[0].place.line, new[0].place.column), (line, column));
    let shown = new[0].to_string();
    let start = format!("docs/coverage.md:{line}:{column}: expected an item that exists");
    assert!(shown.starts_with(&start), "{shown}");
}
