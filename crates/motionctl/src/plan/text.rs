//! The picture in a terminal.

use super::picture::{Block, BlockKind, Picture};

/// Columns of one cycle.
const COLUMNS: usize = 100;
/// Columns of what stands before a row.
const LABEL: usize = 12;

/// Three rows above a ruler.
pub(super) fn draw(picture: &Picture) -> String {
    let rows = [
        ("set-points", BlockKind::SetPoint),
        ("requests", BlockKind::Request),
        ("replies", BlockKind::Replies),
    ];
    let column_us = picture.cycle_us / COLUMNS as f64;
    let mut text = format!(
        "one cycle of {} us, every frame at its longest; a column is {column_us} us\n",
        picture.cycle_us
    );
    for (label, kind) in rows {
        let blocks = picture.blocks.iter().filter(|block| block.kind == kind);
        text += &format!("{label:<LABEL$}{}\n", row(blocks, column_us));
    }
    text += &format!("{:<LABEL$}{}\n", "", ruler());
    text += &format!("{:<LABEL$}{}\n", "us", numbers(picture.cycle_us));
    text += match (has_replies(picture), picture.replies_in_slack) {
        (false, _) => "",
        (true, true) => {
            "Replies, wherever they come in their window, meet no set-point: no jitter.\n"
        }
        (true, false) => "Replies may come among set-points: expect jitter.\n",
    };
    text
}

fn has_replies(picture: &Picture) -> bool {
    let mut kinds = picture.blocks.iter().map(|block| block.kind);
    kinds.any(|kind| kind == BlockKind::Replies)
}

/// A block is a bracket with its label, or dots for a window.
fn row<'a>(blocks: impl Iterator<Item = &'a Block>, column_us: f64) -> String {
    let mut columns = vec![' '; COLUMNS];
    for block in blocks {
        let column = |us: f64| ((us / column_us).round() as usize).min(COLUMNS);
        let (from, until) = (column(block.from_us), column(block.until_us));
        let width = until.saturating_sub(from);
        let fill = match block.kind {
            BlockKind::Replies => '.',
            BlockKind::SetPoint | BlockKind::Request => '=',
        };
        columns[from..until].fill(fill);
        if block.kind != BlockKind::Replies && width > 0 {
            columns[from] = '[';
        }
        let label = block.label.chars().take(width.saturating_sub(2));
        for (place, letter) in label.enumerate() {
            columns[from + 1 + place] = letter;
        }
    }
    String::from_iter(columns).trim_end().to_owned()
}

fn ruler() -> String {
    (0..=COLUMNS)
        .map(|column| if column % 10 == 0 { '|' } else { '-' })
        .collect()
}

fn numbers(cycle_us: f64) -> String {
    let number = |tenth: u32| format!("{:<10}", (cycle_us * f64::from(tenth) / 10.0).round());
    (0..=10)
        .map(number)
        .collect::<String>()
        .trim_end()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_stand_where_they_are() {
        let block = |kind, label: &str, from_us, until_us| Block {
            kind,
            label: label.to_owned(),
            from_us,
            until_us,
        };
        let picture = Picture {
            cycle_us: 1_000.0,
            blocks: vec![
                block(BlockKind::SetPoint, "1", 0.0, 70.0),
                block(BlockKind::SetPoint, "2", 70.0, 140.0),
                block(BlockKind::Request, "?", 140.0, 200.0),
                block(BlockKind::Replies, "", 500.0, 520.0),
            ],
            replies_in_slack: true,
        };
        let text = draw(&picture);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "set-points  [1=====[2=====");
        assert_eq!(lines[2], format!("requests    {}[?====", " ".repeat(14)));
        assert_eq!(lines[3], format!("replies     {}..", " ".repeat(50)));
        assert!(lines[5].starts_with("us          0         100       200"));
    }
}
