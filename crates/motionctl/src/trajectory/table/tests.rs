//! Files as people have them, and what is wrong with some.

use super::*;

fn reading() -> Reading {
    Reading {
        choice: ColumnChoice::default(),
        time_unit: None,
        decimal_comma: false,
        most_duration_s: 3_600.0,
        most_numbers: 10_000,
    }
}

fn read(text: &str) -> Result<Table, String> {
    Table::read(text.as_bytes(), &reading()).map_err(|error| error.to_string())
}

fn choose(text: &str, time: &str, columns: &[&str]) -> Result<Table, String> {
    let mut reading = reading();
    reading.choice.time = (!time.is_empty()).then(|| time.to_owned());
    reading.choice.positions = columns.iter().map(ToString::to_string).collect();
    Table::read(text.as_bytes(), &reading).map_err(|error| error.to_string())
}

/// Times and positions.
fn points(table: &Table) -> Vec<(f64, Vec<f64>)> {
    let row = |point| (table.times_s[point], table.row(point).to_vec());
    (0..table.points()).map(row).collect()
}

#[test]
fn reads_what_people_write() {
    for text in [
        "t,a\n0,1\n1,2\n",
        "# note\nt;a\n0;1\n1;2\n",
        "t a\n0 1 \n1  2 \n",
        "\nt\ta\n0\t1\n\n1\t2",
        "# t a\n0 1\n1 2\n",
        "%time,a\n0,1\n1,2\n",
        "\"t\",\"a\"\n0,\"1\"\n1,2\n",
        "q,vel,t\n1,9,0\n2,9,1\n",
        "t,a\r\n0,1\r\n1,2\r\n",
    ] {
        let table = read(text).unwrap();
        assert_eq!(
            points(&table),
            [(0.0, vec![1.0]), (1.0, vec![2.0])],
            "{text:?}"
        );
    }
}

#[test]
fn errors_name_line_and_column() {
    for (text, expected) in [
        (
            "t,a\n0,1\n1,fast\n",
            "line 3, column 2 (a): expected a number, got \"fast\"",
        ),
        (
            "t a\n0 1\n1 nan\n",
            "line 3, column 2 (a): expected a finite number, got nan",
        ),
        (
            "t,a\n0,1\n1,\n",
            "line 3, column 2 (a): expected a number, got an empty field",
        ),
        (
            "t,a\n# c\n0,1\n1\n",
            "line 4: expected 2 columns as in line 1, got 1; column 2 (a) is missing",
        ),
        (
            "t,a\n0,1,\n",
            "line 2: expected 2 columns as in line 1, got 3",
        ),
        (
            "t;a\n0,5;1\n",
            "line 2, column 1 (t): expected a number with a decimal point, got \"0,5\"",
        ),
        (
            "0,1,,3\n",
            "line 1, column 3: expected a number, got an empty field",
        ),
        (
            ",,\n",
            "line 1, column 1: expected a number, got an empty field",
        ),
        (
            "0,x,0\n",
            "line 1 mixes numbers and text: column 1 is the number 0, column 2 is \"x\"",
        ),
        (
            "t,a\n1,1\n1.0,2\n",
            "line 3, column 1 (t): time must increase, got 1.0 after 1",
        ),
        ("# nothing\n", "no line with numbers"),
        ("t,a\n", "no line with numbers"),
        ("t,a\n0,1\n", "line 2: only one point"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
}

#[test]
fn a_column_that_is_not_wanted_may_hold_anything() {
    let text = "t,n,a\n0,j1,2\n1,,3\n";
    assert!(
        read(text)
            .unwrap_err()
            .contains("column 2 (n) may be an axis")
    );
    let table = choose(text, "", &["a"]).unwrap();
    assert_eq!(points(&table), [(0.0, vec![2.0]), (1.0, vec![3.0])]);
    let table = choose("0,,2\n1,,3\n", "1", &["3"]).unwrap();
    assert_eq!(points(&table), [(0.0, vec![2.0]), (1.0, vec![3.0])]);
}

#[test]
fn without_names_only_one_reading_runs() {
    let table = read("0 0\n1 5\n2 5\n").unwrap();
    assert_eq!(table.columns.time.index, 0);
    assert_eq!(points(&table).len(), 3);
    for text in [
        "0 0\n1 1\n",
        "0 0\n0 1\n1 2\n",
        "5 0\n4 1\n",
        "0 0 0\n1 1 0\n",
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains("columns without names"), "{text:?}: {error}");
        assert!(
            error.contains("--time-column N and --columns N,M"),
            "{error}"
        );
    }
    assert_eq!(points(&choose("0 0\n1 1\n", "1", &[]).unwrap()).len(), 2);
}

#[test]
fn a_motion_too_long_to_be_meant_is_refused_with_its_duration() {
    let stamps = "t,a\n1700000000000000000,0\n1700000000500000001,10\n1700000003600000000,20\n";
    let error = read(stamps).unwrap_err();
    assert!(
        error.starts_with("line 3, column 1 (t): read in s the motion lasts 114.1 years, expected at most 3600 s; with --time-unit it would be 3600 s in us, 3.6 s in ns; --max-duration raises the limit"),
        "{error}"
    );
    let nanoseconds = Reading {
        time_unit: Some(TimeUnit::Ns),
        ..reading()
    };
    let table = Table::read(stamps.as_bytes(), &nanoseconds).unwrap();
    assert_eq!(table.times_s, [0.0, 0.500_000_001, 3.6]);
}

#[test]
fn two_times_that_a_number_cannot_tell_apart_are_one() {
    let text = "t,a\n0,0\n3599.000000000001,1\n3599.0000000000011,2\n";
    assert!(read(text).unwrap_err().contains("time must increase"));
}

#[test]
fn decimal_commas_are_read_when_they_are_asked_for() {
    let comma = Reading {
        decimal_comma: true,
        ..reading()
    };
    let table = Table::read(&b"t;a\n0;1,5\n0,5;2\n"[..], &comma).unwrap();
    assert_eq!(points(&table), [(0.0, vec![1.5]), (0.5, vec![2.0])]);
    let error = Table::read(&b"t;a\n0;1.5\n"[..], &comma).unwrap_err();
    assert!(error.to_string().contains("got \"1.5\""), "{error}");
}

#[test]
fn more_numbers_than_a_motion_has_are_refused_in_their_line() {
    let few = Reading {
        most_numbers: 6,
        ..reading()
    };
    let text = "t,a\n0,0\n1,1\n2,2\n3,3\n";
    let error = Table::read(text.as_bytes(), &few).unwrap_err().to_string();
    assert!(
        error.starts_with("line 5: expected at most 6 times and positions"),
        "{error}"
    );
    // Also when nothing of it is kept because it lasts too long.
    let short = Reading {
        most_duration_s: 0.5,
        ..few
    };
    let error = Table::read(text.as_bytes(), &short)
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("line 5: expected at most 6"), "{error}");
}

#[test]
fn a_spreadsheet_error_in_front_is_no_comment() {
    for text in [
        "t,x\n0,0\n#DIV/0!,5\n2,0\n",
        "t;x\n0;0\n#REF!;5\n2;0\n",
        "t,x\n0,0\n########,5\n2,0\n",
    ] {
        let error = read(text).unwrap_err();
        assert!(
            error.starts_with("line 3, column 1 (t): expected a number, got \"#"),
            "{text:?}: {error}"
        );
    }
    // A point that was taken out, and a remark.
    for line in ["#1,5", "# 1,5", "# pause, then on", "#", "% x", "#a,b"] {
        let text = format!("t,x\n0,0\n{line}\n2,4\n");
        assert_eq!(points(&read(&text).unwrap()).len(), 2, "{text:?}");
    }
}

#[test]
fn a_sentence_is_no_header() {
    for text in [
        "# run at time 3\n0 1 2 3\n1 2 3 4\n",
        "# start of time\n0 0 1\n1 5 2\n",
        "# time = 3\n0 1 2\n1 2 3\n",
        "# time: 12:00\n0 1\n1 2\n",
        "# any time\n5 0\n6 1\n5 2\n",
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains("columns without names"), "{text:?}: {error}");
    }
    assert_eq!(
        points(&read("# time x y\n0 1 2\n1 2 3\n").unwrap()).len(),
        2
    );
}

#[test]
fn a_quotation_mark_that_stays_open_is_refused() {
    for text in ["t,x\n0,\"0\n1,10\n", "\"t\n(s)\",x\n0,0\n1,10\n"] {
        let error = read(text).unwrap_err();
        assert!(
            error.contains("a quotation mark is open at the end of the line"),
            "{text:?}: {error}"
        );
    }
}

#[test]
fn too_few_columns_are_refused_in_their_line() {
    let error = read("\n5\n6\n").unwrap_err();
    assert!(
        error.starts_with("line 2: expected time and 1 axis, got 0 columns"),
        "{error}"
    );
}

#[test]
fn two_columns_that_both_increase_do_not_fill_the_memory() {
    let mut lines = 0_u64;
    let rows = core::iter::from_fn(|| {
        lines += 1;
        (lines < 300_000).then_some(Ok(format!("{lines} {lines}\n").into_bytes()))
    });
    let many = Reading {
        most_numbers: usize::MAX,
        ..reading()
    };
    let error = Table::read(std::io::BufReader::new(Rows(rows)), &many).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("line 1: 2 columns without names"),
        "{error}"
    );
    assert!(lines < 200_000, "{lines} lines were read");
}

/// Lines as a file that has no end.
struct Rows<I>(I);

impl<I: Iterator<Item = std::io::Result<Vec<u8>>>> std::io::Read for Rows<I> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let row = self.0.next().transpose()?.unwrap_or_default();
        buffer[..row.len()].copy_from_slice(&row);
        Ok(row.len())
    }
}

#[test]
fn a_motion_may_last_exactly_as_long_as_it_may() {
    assert_eq!(points(&read("t,a\n5,0\n3605,1\n").unwrap()).len(), 2);
    let error = read("t,a\n5,0\n3605.001,1\n").unwrap_err();
    assert!(
        error.contains("lasts 3600.001 s, expected at most 3600 s"),
        "{error}"
    );
}
