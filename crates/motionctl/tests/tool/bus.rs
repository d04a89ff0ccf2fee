//! What was on the bus.

/// Positions of the drives 1, 2 and so on, cycle by cycle, from the steps of `Go_Relative_Pos_PD` in a candump log.
pub(crate) fn positions(log: &str, drives: usize) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(log).expect("a log");
    let mut axes = vec![vec![0.0]; drives];
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
        let step = (raw ^ sign) - sign;
        let axis = &mut axes[usize::from(id >> 5) - 1];
        let before = axis.last().copied().unwrap_or(0.0);
        axis.push(before + step as f64);
    }
    axes
}
