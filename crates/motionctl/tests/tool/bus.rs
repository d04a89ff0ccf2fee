//! What was on the bus.

/// Positions of the drives 1, 2 and so on, cycle by cycle, from the steps of `Go_Relative_Pos_PD` in a candump log.
pub(crate) fn positions(log: &str, drives: usize) -> Vec<Vec<f64>> {
    let sums = |steps: Vec<i64>| {
        let mut position = 0;
        let after = steps.into_iter().map(|step| {
            position += step;
            position as f64
        });
        core::iter::once(0.0).chain(after).collect()
    };
    steps(log, drives).into_iter().map(sums).collect()
}

/// The steps themselves, of each drive in the order of their frames.
pub(crate) fn steps(log: &str, drives: usize) -> Vec<Vec<i64>> {
    let text = std::fs::read_to_string(log).expect("a log");
    let mut axes = vec![Vec::new(); drives];
    for line in text.lines() {
        let frame = line.split_whitespace().nth(2).expect("a frame");
        let (id, data) = frame.split_once('#').expect("an identifier");
        let id = u16::from_str_radix(id, 16).expect("hexadecimal");
        // Function 1Ch, and the drive in the bits above it.
        if id & 0x1F != 0x1C {
            continue;
        }
        let bytes = data.len() / 2;
        let raw = i64::from_str_radix(data, 16).expect("hexadecimal");
        let sign = 1 << (8 * bytes - 1);
        axes[usize::from(id >> 5) - 1].push((raw ^ sign) - sign);
    }
    axes
}
