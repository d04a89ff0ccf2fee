//! The block of numbers of a page, read by itself: the page's script and this are two readers of one writer.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// A page.
pub(crate) struct Page {
    data: Value,
    /// End of each cycle since the start of the recording, in microseconds.
    pub(crate) times_us: Vec<i64>,
    /// Number of each cycle on the clock.
    pub(crate) numbers: Vec<i64>,
}

impl Page {
    /// The page in this text.
    pub(crate) fn of(text: &str) -> Self {
        let block = text
            .split("id=\"data\">")
            .nth(1)
            .expect("a block of numbers");
        let block = block.split("</script>").next().expect("its end");
        let data: Value = serde_json::from_str(block).expect("JSON");
        Self {
            times_us: running_sums(&data["samples"]["timesUs"]),
            numbers: running_sums(&data["samples"]["numbers"]),
            data,
        }
    }

    /// The page in a folder.
    pub(crate) fn in_folder(folder: &str) -> Self {
        let path = std::path::Path::new(folder).join("index.html");
        Self::of(&std::fs::read_to_string(path).expect("the page"))
    }

    pub(crate) fn data(&self) -> &Value {
        &self.data
    }

    /// Names of the axes.
    pub(crate) fn axes(&self) -> Vec<String> {
        let axes = self.data["axes"].as_array().expect("axes");
        let name = |axis: &Value| axis["name"].as_str().expect("a name").to_owned();
        axes.iter().map(name).collect()
    }

    /// How many frames are in it.
    pub(crate) fn frames(&self) -> usize {
        numbers(&self.data["frames"]).len() / 3
    }

    /// Place and number on the clock of the first cycle of the motion.
    pub(crate) fn motion_start(&self) -> (usize, i64) {
        let start = &self.data["motionStart"];
        let (at_us, number) = (start[0].as_i64(), start[1].as_i64());
        let at_us = at_us.expect("a time");
        let place = self.times_us.iter().position(|time| *time >= at_us);
        (place.expect("a cycle"), number.expect("a number"))
    }

    /// Where the set-points take an axis, cycle by cycle, in counts.
    pub(crate) fn sent(&self, axis: usize) -> Vec<i64> {
        running_sums(&self.data["axes"][axis]["sent"])
    }

    /// Where the application wants an axis, cycle by cycle, in counts.
    pub(crate) fn target(&self, axis: usize) -> Vec<i64> {
        running_sums(&self.data["axes"][axis]["target"])
    }

    /// Place of the cycle and counts of every position that is known.
    pub(crate) fn positions(&self, axis: usize) -> Vec<(usize, i64)> {
        let numbers = numbers(&self.data["axes"][axis]["position"]);
        let (mut place, mut value) = (-1_i64, 0);
        let pair = |pair: &[u64]| {
            place += pair[0] as i64;
            value += signed(pair[1]);
            (place as usize, value)
        };
        numbers.chunks(2).map(pair).collect()
    }

    /// Where the set-points took an axis until a moment, or nothing before the first cycle.
    pub(crate) fn sent_at(&self, sent: &[i64], at_us: i64) -> Option<i64> {
        let place = self.times_us.partition_point(|time| *time <= at_us);
        sent.get(place.checked_sub(1)?).copied()
    }
}

fn numbers(block: &Value) -> Vec<u64> {
    let bytes = STANDARD
        .decode(block.as_str().expect("a block"))
        .expect("base64");
    let (mut all, mut number, mut shift) = (Vec::new(), 0_u64, 0);
    for byte in bytes {
        number |= u64::from(byte & 0x7F) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            all.push(number);
            (number, shift) = (0, 0);
        }
    }
    assert_eq!(shift, 0, "the last number is cut off");
    all
}

/// 0, 1, 2, 3 ... are 0, -1, 1, -2 ...
fn signed(number: u64) -> i64 {
    let half = (number / 2) as i64;
    if number.is_multiple_of(2) {
        half
    } else {
        -half - 1
    }
}

fn running_sums(block: &Value) -> Vec<i64> {
    let mut sum = 0;
    let add = |number: &u64| {
        sum += signed(*number);
        sum
    };
    numbers(block).iter().map(add).collect()
}
