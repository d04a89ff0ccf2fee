//! The table "class of frame x facts" of docs/master.md, read row by row and compared with the exit.

use std::path::Path;

use can_motion::facts::{Class, Facts};

use crate::rules::{BRAKES, RULES, every_combination};

const BEGIN: &str = "<!-- frames and facts: begin -->";
const END: &str = "<!-- frames and facts: end -->";

/// A row: the class, the values of the facts in the order of the columns, and how many combinations can be reached.
struct Row<'a> {
    class: &'a str,
    values: Vec<&'a str>,
    counts: Vec<usize>,
}

impl<'a> Row<'a> {
    fn read(line: &'a str) -> Self {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert_eq!(cells.len(), 10, "10 columns: {line}");
        let count = |cell: &str| cell.parse().unwrap_or_else(|_| panic!("a number: {line}"));
        Self {
            class: cells[0],
            values: cells[1..8].to_vec(),
            counts: cells[8..].iter().map(|cell| count(cell)).collect(),
        }
    }

    fn holds(&self, class: Class, facts: &Facts) -> bool {
        let actual = [
            format!("{:?}", facts.power),
            format!("{:?}", facts.motion),
            format!("{:?}", facts.goal),
            format!("{:?}", facts.knowledge),
            format!("{:?}", facts.latch),
            format!("{:?}", facts.work),
            format!("{:?}", facts.brake),
        ];
        let is_one_of = |cell: &str, actual: &str| {
            cell == "any" || cell.split(", ").any(|value| value == actual)
        };
        let mut pairs = self.values.iter().zip(&actual);
        self.class == format!("{class:?}") && pairs.all(|(cell, actual)| is_one_of(cell, actual))
    }
}

#[test]
fn the_table_in_the_docs_is_the_exit() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/master.md");
    let docs = std::fs::read_to_string(path).expect("docs/master.md");
    let table = docs.split_once(BEGIN).expect(BEGIN).1;
    let table = table.split_once(END).expect(END).0;
    let lines = table.trim().lines().skip(2);
    let rows: Vec<Row<'_>> = lines.map(Row::read).collect();
    for facts in every_combination() {
        for class in Class::ALL {
            let hits = rows.iter().filter(|row| row.holds(class, &facts)).count();
            let expected = usize::from((RULES.may_leave)(class, &facts));
            assert_eq!(
                hits, expected,
                "rows of the table for {class:?} with {facts:?}"
            );
        }
    }
    let reachable = BRAKES.map(|brake| RULES.walk_one(brake, |_, _, _| Ok(())).expect("no check"));
    for row in rows {
        let count = |seen: &Vec<Facts>| {
            let leaves = |facts: &&Facts| Class::ALL.iter().any(|&class| row.holds(class, facts));
            seen.iter().filter(leaves).count()
        };
        let actual: Vec<usize> = reachable.iter().map(count).collect();
        println!("{} {:?}: {actual:?} combinations", row.class, row.values);
        assert_eq!(
            row.counts, actual,
            "the counts of {} {:?}",
            row.class, row.values
        );
    }
}
