//! The picture as SVG: one cycle in rows, so narrow that its text is readable on a telephone.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::error::PlanError;
use super::picture::{Block, BlockKind, Picture};

/// A cycle is cut into so many rows.
const ROWS: u32 = 4;
const WIDTH: u32 = 480;
const MARGIN: i32 = 24;
/// Top of the first row, and the height of each: lanes, marks of time, gap.
const FIRST_ROW: i32 = 56;
const ROW_HEIGHT: i32 = 118;
const SIZE: (u32, u32) = (WIDTH, FIRST_ROW as u32 + ROWS * ROW_HEIGHT as u32);
/// Top and bottom within a row of the frames of the master, and of the replies.
const LANES: [(BlockKind, i32, i32, RGBColor); 3] = [
    (BlockKind::SetPoint, 0, 40, RGBColor(70, 120, 190)),
    (BlockKind::Request, 0, 40, RGBColor(176, 98, 0)),
    (BlockKind::Replies, 46, 72, RGBColor(120, 100, 70)),
];
const MARKS: (i32, i32, i32) = (76, 82, 86);
/// Marks of time in a row.
const TICKS: u32 = 5;
/// Pixels of the font, and how wide a letter is at most: what does not fit into its block has no label.
const FONT_PIXELS: f64 = 13.0;
const LETTER_PIXELS: i32 = 8;

/// The text of the file.
pub(super) fn draw(picture: &Picture) -> Result<String, PlanError> {
    let mut text = String::new();
    on(picture, SVGBackend::with_string(&mut text, SIZE)).map_err(PlanError::Draw)?;
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn on(picture: &Picture, backend: SVGBackend<'_>) -> Result<(), String> {
    let area = backend.into_drawing_area();
    area.fill(&WHITE).map_err(reason)?;
    let title = format!(
        "One cycle of {} us, every frame at its longest;",
        picture.cycle_us
    );
    for (line, y) in [
        (title.as_str(), 8),
        ("below, where the replies may come", 26),
    ] {
        area.draw(&Text::new(line.to_owned(), (MARGIN, y), font()))
            .map_err(reason)?;
    }
    for row in 0..ROWS {
        let row = Row::new(picture, row);
        for block in &picture.blocks {
            row.draw(&area, block)?;
        }
        row.draw_time(&area)?;
    }
    area.present().map_err(reason)
}

fn reason(error: impl core::fmt::Display) -> String {
    error.to_string()
}

fn font<'a>() -> TextStyle<'a> {
    // The library takes points of a font whose pixels are fewer.
    ("sans-serif", FONT_PIXELS * 1.24).into_font().color(&BLACK)
}

/// A part of the cycle.
struct Row {
    from_us: f64,
    length_us: f64,
    top: i32,
}

impl Row {
    fn new(picture: &Picture, number: u32) -> Self {
        let length_us = picture.cycle_us / f64::from(ROWS);
        Self {
            from_us: f64::from(number) * length_us,
            length_us,
            top: FIRST_ROW + number as i32 * ROW_HEIGHT,
        }
    }

    fn until_us(&self) -> f64 {
        self.from_us + self.length_us
    }

    fn pixel(&self, us: f64) -> i32 {
        let width = f64::from(WIDTH) - 2.0 * f64::from(MARGIN);
        MARGIN + ((us - self.from_us) / self.length_us * width).round() as i32
    }

    /// The part of a block that lies in this row.
    fn draw(&self, area: &Area<'_>, block: &Block) -> Result<(), String> {
        let from_us = block.from_us.max(self.from_us);
        let until_us = block.until_us.min(self.until_us());
        if from_us >= until_us {
            return Ok(());
        }
        for (_, top, bottom, colour) in LANES.iter().filter(|lane| lane.0 == block.kind) {
            let (left, right) = (self.pixel(from_us), self.pixel(until_us));
            let (top, bottom) = (self.top + top, self.top + bottom);
            let corners = [(left, top), (right, bottom)];
            area.draw(&Rectangle::new(corners, colour.filled()))
                .map_err(reason)?;
            let edge = ShapeStyle::from(&WHITE).stroke_width(1);
            area.draw(&Rectangle::new(corners, edge)).map_err(reason)?;
            if block.label.chars().count() as i32 * LETTER_PIXELS <= right - left {
                let middle = ((left + right) / 2, (top + bottom) / 2);
                let label = font()
                    .color(&WHITE)
                    .pos(Pos::new(HPos::Center, VPos::Center));
                area.draw(&Text::new(block.label.clone(), middle, label))
                    .map_err(reason)?;
            }
        }
        Ok(())
    }

    fn draw_time(&self, area: &Area<'_>) -> Result<(), String> {
        let (top, bottom, numbers) = MARKS;
        for tick in 0..=TICKS {
            let us = self.from_us + self.length_us * f64::from(tick) / f64::from(TICKS);
            let x = self.pixel(us);
            let mark = vec![(x, self.top + top), (x, self.top + bottom)];
            area.draw(&PathElement::new(mark, BLACK)).map_err(reason)?;
            let number = font().pos(Pos::new(HPos::Center, VPos::Top));
            let place = (x, self.top + numbers);
            area.draw(&Text::new(format!("{us:.0}"), place, number))
                .map_err(reason)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(cycle_us: f64) -> String {
        let block = |kind, from_us, until_us, label: &str| Block {
            kind,
            from_us,
            until_us,
            label: label.to_owned(),
        };
        draw(&Picture {
            cycle_us,
            replies_in_slack: true,
            blocks: vec![
                block(BlockKind::SetPoint, 0.0, 0.26 * cycle_us, "first"),
                block(
                    BlockKind::SetPoint,
                    0.3 * cycle_us,
                    0.301 * cycle_us,
                    "narrow",
                ),
                block(BlockKind::Replies, 0.5 * cycle_us, cycle_us, "replies"),
            ],
        })
        .expect("a picture")
    }

    /// The numbers of an attribute in the file.
    fn numbers(svg: &str, attribute: &str) -> Vec<f64> {
        svg.split(&format!(" {attribute}=\""))
            .skip(1)
            .filter_map(|rest| rest.split('"').next()?.parse().ok())
            .collect()
    }

    #[test]
    fn the_text_is_readable_on_400_pixels_and_inside_the_picture() {
        for cycle_us in [250.0, 1_000.0, 1_000_000.0] {
            let svg = picture(cycle_us);
            assert!(svg.contains("viewBox=\"0 0 480 "), "{svg}");
            // Scaled to 400 pixels no text is below 10 pixels.
            let least = numbers(&svg, "font-size")
                .into_iter()
                .fold(f64::MAX, f64::min);
            assert!(least * 400.0 / f64::from(WIDTH) >= 10.0, "{least}");
            for x in numbers(&svg, "x") {
                assert!((0.0..f64::from(WIDTH)).contains(&x), "{x}");
            }
            for y in numbers(&svg, "y") {
                assert!((0.0..f64::from(SIZE.1)).contains(&y), "{y}");
            }
        }
    }

    #[test]
    fn a_block_goes_on_in_the_next_row_and_a_label_that_does_not_fit_is_left_out() {
        let svg = picture(1_000.0);
        // The block of 260 us is in the rows of 0 and of 250 us; its label fits into the first part only.
        assert_eq!(svg.matches("first").count(), 1);
        assert_eq!(svg.matches("narrow").count(), 0);
        assert_eq!(svg.matches("replies").count(), 2 + 1, "{svg}");
    }
}
