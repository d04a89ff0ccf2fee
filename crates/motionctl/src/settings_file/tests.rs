use dyn_can::{Revision, StoredDriveId};
use proptest::prelude::*;
use toml::value::Datetime;

use super::*;

const GOOD: &str = "\
format = 1
tool = \"motionctl 0.1.0\"
date = 2026-11-29T05:42:14Z

[[drive]]
id = 3
revision = \"1.6A\"
config = 0x00
main-gain = 20
speed-gain = 21
integration-gain = 10
torque-filter = 127
max-speed = 60
max-acceleration = 61
on-position-range = 20
gear-number = 4096
line-number = 0
";

fn id(number: i32) -> StoredDriveId {
    StoredDriveId::new(number).unwrap()
}

#[test]
fn a_good_file_is_read_as_it_says() {
    let drives = parse(GOOD).unwrap();
    let [drive] = drives.as_slice() else {
        panic!("{drives:?}")
    };
    assert_eq!(drive.id, id(3));
    assert_eq!(drive.revision, FileRevision::Can(Revision::V1_6A));
    let value = |parameter| drive.value(parameter);
    assert_eq!(value(Parameter::Config), Some(0));
    assert_eq!(value(Parameter::SpeedGain), Some(21));
    assert_eq!(value(Parameter::MaxAcceleration), Some(61));
    assert_eq!(value(Parameter::GearNumber), Some(4_096));
    assert_eq!(value(Parameter::LineNumber), None);
    assert_eq!(drive.settings.len(), 9);
    let with_line = GOOD.replace("line-number = 0", "line-number = 2_500");
    assert_eq!(
        parse(&with_line).unwrap()[0].value(Parameter::LineNumber),
        Some(2_500)
    );
    // Windows writes lines that end in CR LF, and people write comments.
    let others = GOOD.replace('\n', "  # a remark\r\n");
    assert_eq!(parse(&others).unwrap(), drives);
}

/// Replaces one text by another in the good file; where it goes wrong, and what the message says.
fn refusal(from: &str, to: &str) -> (usize, usize, String) {
    assert!(GOOD.contains(from), "{from}");
    let error = parse(&GOOD.replacen(from, to, 1)).unwrap_err();
    (error.place.line, error.place.column, error.to_string())
}

#[test]
fn what_is_wrong_is_said_with_its_place_and_what_to_do() {
    let mut wrong = Vec::new();
    for (from, to, line, column, words) in [
        // Not TOML.
        ("format = 1", "format 1", 1, 8, "TOML"),
        ("format = 1", "format = ", 1, 10, "TOML"),
        ("\"1.6A\"", "\"1.6A", 7, 17, "TOML"),
        ("[[drive]]", "[[drive]", 5, 9, "TOML"),
        (
            "main-gain = 20",
            "main-gain = 20\nmain-gain = 20",
            10,
            1,
            "duplicate key",
        ),
        ("main-gain = 20", "main-gain = 020", 9, 13, "TOML"),
        ("0x00", "0xZZ", 8, 12, "TOML"),
        // The head.
        ("format = 1\n", "", 1, 1, "`format` in the file"),
        (
            "format = 1",
            "format = 2",
            1,
            10,
            "expected format = 1, got format = 2",
        ),
        ("format = 1", "format = \"1\"", 1, 10, "a TOML string"),
        ("tool", "tools", 2, 1, "\"tools\"; correct or remove it"),
        ("\"motionctl 0.1.0\"", "7", 2, 8, "got 7 (a TOML integer)"),
        ("2026-11-29T05:42:14Z", "\"today\"", 3, 8, "expected a date"),
        (
            "date = 2026-11-29T05:42:14Z\n",
            "",
            1,
            1,
            "`date` in the file",
        ),
        (
            "format = 1",
            "format = 1\nowner = \"me\"",
            2,
            1,
            "\"owner\"",
        ),
        // The drives.
        ("[[drive]]", "[drive]", 5, 1, "got a TOML table"),
        ("[[drive]]", "[[drives]]", 5, 3, "\"drives\""),
        ("id = 3\n", "", 5, 1, "`id` in [[drive]]"),
        ("id = 3", "id = 64", 6, 6, "a drive id from 0 to 63, got 64"),
        ("id = 3", "id = -1", 6, 6, "got -1"),
        ("id = 3", "id = 3.0", 6, 6, "got 3.0 (a TOML float)"),
        (
            "id = 3",
            "id = 99999999999999999999",
            6,
            6,
            "write a number that fits",
        ),
        ("id = 3", "id = 4294967299", 6, 6, "got 4294967299"),
        (
            "\"1.6A\"",
            "\"1.6B\"",
            7,
            12,
            "got \"1.6B\"; `motionctl scan`",
        ),
        ("\"1.6A\"", "1.6", 7, 12, "got 1.6 (a TOML float)"),
        ("revision = \"1.6A\"\n", "", 5, 1, "`revision` in [[drive]]"),
        // The settings.
        (
            "main-gain = 20\n",
            "",
            5,
            1,
            "`main-gain` in [[drive]]: main-gain from 1 to 127, got nothing",
        ),
        (
            "main-gain = 20",
            "main-gian = 20",
            9,
            1,
            "got \"main-gian\"",
        ),
        (
            "main-gain = 20",
            "main-gain = 0",
            9,
            13,
            "main-gain from 1 to 127, got 0",
        ),
        ("main-gain = 20", "main-gain = 128", 9, 13, "got 128"),
        ("main-gain = 20", "main-gain = -20", 9, 13, "got -20"),
        (
            "main-gain = 20",
            "main-gain = 20.5",
            9,
            13,
            "got 20.5 (a TOML float)",
        ),
        (
            "main-gain = 20",
            "main-gain = \"20\"",
            9,
            13,
            "got \"20\" (a TOML string)",
        ),
        (
            "main-gain = 20",
            "main-gain = true",
            9,
            13,
            "got true (a TOML boolean)",
        ),
        (
            "main-gain = 20",
            "main-gain = [20]",
            9,
            13,
            "got a TOML array",
        ),
        (
            "main-gain = 20",
            "main-gain = { raw = 20 }",
            9,
            13,
            "got a TOML table",
        ),
        ("config = 0x00", "config = 0x18", 8, 10, "servo mode"),
        (
            "config = 0x00",
            "config = 0x40",
            8,
            10,
            "config from 0 to 63, got 64",
        ),
        (
            "gear-number = 4096",
            "gear-number = 499",
            16,
            15,
            "gear-number from 500 to 16384, got 499",
        ),
        (
            "line-number = 0",
            "line-number = 499",
            17,
            15,
            "from 500 to 4095, or 0 for none, got 499",
        ),
        ("line-number = 0\n", "", 5, 1, "`line-number` in [[drive]]"),
        (
            "on-position-range = 20",
            "on_position_range = 20",
            15,
            1,
            "got \"on_position_range\"",
        ),
        // A letter of more than one byte is one column.
        ("main-gain = 20", "ä = 1", 9, 1, "TOML"),
        (
            "tool = \"motionctl 0.1.0\"",
            "tool = \"ä\" 1",
            2,
            12,
            "TOML",
        ),
    ] {
        let (at_line, at_column, message) = refusal(from, to);
        let start = format!("line {line}, column {column}: expected ");
        if (at_line, at_column) != (line, column)
            || !message.starts_with(&start)
            || !message.contains(words)
            || !message.contains("; ")
        {
            wrong.push(format!("{to}: {message}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_file_without_a_drive_or_with_one_twice_is_refused() {
    let twice = format!("{GOOD}{}", &GOOD[GOOD.find("[[drive]]").unwrap()..]);
    let error = parse(&twice).unwrap_err();
    assert_eq!((error.place.line, error.place.column), (19, 6), "{error}");
    assert!(error.to_string().contains("got drive 3 a second time"));
    let head = &GOOD[..GOOD.find("[[drive]]").unwrap()];
    for (none, column) in [(head.to_owned(), 1), (format!("{head}drive = []\n"), 9)] {
        let error = parse(&none).unwrap_err();
        assert_eq!(error.place.column, column, "{error}");
        assert!(error.to_string().contains("[[drive]]"), "{error}");
    }
    assert!(parse("").is_err());
}

fn origin() -> Origin {
    Origin {
        tool: "motionctl 9.9.9".to_owned(),
        date: "2026-01-02T03:04:05Z".parse::<Datetime>().unwrap(),
    }
}

#[test]
fn a_file_says_what_its_numbers_mean() {
    let drives = parse(GOOD).unwrap();
    let text = write(&origin(), &drives);
    for line in [
        "tool = \"motionctl 9.9.9\"",
        "date = 2026-01-02T03:04:05Z",
        "id = 3",
        "revision = \"1.6A\"",
        "config = 0x00  # commands by link, position servo, relative",
        // (60 + 3)^2 / 16 * 12.21 rpm, and 61 * 635.78 rpm/s (DYN2 manual A1.8 section 7).
        "max-speed = 60  # 3028.8 rpm",
        "max-acceleration = 61  # 38783 rpm/s",
        "line-number = 0  # the drive has none",
    ] {
        assert!(
            text.lines().any(|present| present == line),
            "{line}: {text}"
        );
    }
}

#[test]
fn settings_of_a_serial_port_have_no_line_number() {
    let mut drives = parse(GOOD).unwrap();
    drives[0].revision = FileRevision::Unknown;
    drives[0].id = id(0);
    let text = write(&origin(), &drives);
    assert!(text.contains("# line-number = 0"), "{text}");
    assert_eq!(parse(&text).unwrap(), drives);
}

fn settings() -> impl Strategy<Value = Vec<Setting>> {
    let value = |parameter: Parameter| {
        let (least, most) = parameter.limits();
        least..=most
    };
    let all: Vec<_> = [
        Parameter::Config,
        Parameter::MainGain,
        Parameter::SpeedGain,
        Parameter::IntegrationGain,
        Parameter::TorqueFilter,
        Parameter::MaxSpeed,
        Parameter::MaxAcceleration,
        Parameter::OnPositionRange,
        Parameter::GearNumber,
        Parameter::LineNumber,
    ]
    .into_iter()
    .map(|parameter| value(parameter).prop_map(move |value| (parameter, value)))
    .collect();
    all.prop_map(|values| {
        let setting = |(parameter, value)| Setting::new(parameter, value).ok();
        // Servo mode 3 is undefined: such a configuration is that of the factory instead.
        let or_zero =
            |(parameter, value)| setting((parameter, value)).or_else(|| setting((parameter, 0)));
        values.into_iter().filter_map(or_zero).collect()
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(
        all in proptest::collection::btree_map(0..=63_i32, (settings(), any::<bool>()), 1..8)
    ) {
        let drives: Vec<DriveSettings> = all
            .into_iter()
            .map(|(number, (settings, is_old))| DriveSettings {
                id: id(number),
                revision: FileRevision::Can(if is_old { Revision::V1_2A } else { Revision::V1_6A }),
                settings,
            })
            .collect();
        prop_assert_eq!(parse(&write(&origin(), &drives)).unwrap(), drives);
    }

    #[test]
    fn no_text_makes_it_panic(text in ".*", at in 0..400_usize, byte in any::<u8>()) {
        let _ = parse(&text);
        let mut bytes = GOOD.as_bytes().to_vec();
        let place = at % bytes.len();
        bytes[place] = byte;
        let _ = parse(&String::from_utf8_lossy(&bytes));
    }
}
