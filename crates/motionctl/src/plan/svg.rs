//! The picture as SVG.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::error::PlanError;
use super::picture::{Block, BlockKind, Picture};

const SIZE: (u32, u32) = (1_000, 190);
const MARGIN: i32 = 30;
/// Height of the lane of the frames of the master, and of the replies.
const LANES: [(BlockKind, i32, i32, RGBColor); 3] = [
    (BlockKind::SetPoint, 50, 95, RGBColor(70, 120, 190)),
    (BlockKind::Request, 50, 95, RGBColor(220, 140, 40)),
    (BlockKind::Replies, 105, 135, RGBColor(150, 130, 100)),
];

/// The text of the file.
pub(super) fn draw(picture: &Picture) -> Result<String, PlanError> {
    let mut text = String::new();
    on(picture, SVGBackend::with_string(&mut text, SIZE)).map_err(PlanError::Draw)?;
    Ok(text)
}

fn on(picture: &Picture, backend: SVGBackend<'_>) -> Result<(), String> {
    let area = backend.into_drawing_area();
    let reason = |error: DrawingAreaErrorKind<_>| error.to_string();
    area.fill(&WHITE).map_err(reason)?;
    let title = format!(
        "One cycle of {} us, every frame at its longest; below, where the replies may come",
        picture.cycle_us
    );
    area.draw(&Text::new(title, (MARGIN, 24), font()))
        .map_err(reason)?;
    for block in &picture.blocks {
        for (_, top, bottom, colour) in LANES.iter().filter(|lane| lane.0 == block.kind) {
            let corners = corners(picture, block, *top, *bottom);
            let edge = ShapeStyle::from(&WHITE).stroke_width(1);
            area.draw(&Rectangle::new(corners, colour.filled()))
                .map_err(reason)?;
            area.draw(&Rectangle::new(corners, edge)).map_err(reason)?;
            let [(left, _), (right, _)] = corners;
            let middle = ((left + right) / 2, (top + bottom) / 2);
            let label = font()
                .color(&WHITE)
                .pos(Pos::new(HPos::Center, VPos::Center));
            area.draw(&Text::new(block.label.clone(), middle, label))
                .map_err(reason)?;
        }
    }
    for tenth in 0..=10 {
        let us = picture.cycle_us * f64::from(tenth) / 10.0;
        let x = pixel(picture, us);
        area.draw(&PathElement::new(vec![(x, 142), (x, 148)], BLACK))
            .map_err(reason)?;
        let number = font().pos(Pos::new(HPos::Center, VPos::Top));
        area.draw(&Text::new(format!("{us:.0} us"), (x, 154), number))
            .map_err(reason)?;
    }
    area.present().map_err(reason)
}

fn font<'a>() -> TextStyle<'a> {
    ("sans-serif", 13).into_text_style(&SIZE).color(&BLACK)
}

fn pixel(picture: &Picture, us: f64) -> i32 {
    let width = f64::from(SIZE.0) - 2.0 * f64::from(MARGIN);
    MARGIN + (us / picture.cycle_us * width).round() as i32
}

fn corners(picture: &Picture, block: &Block, top: i32, bottom: i32) -> [(i32, i32); 2] {
    [
        (pixel(picture, block.from_us), top),
        (pixel(picture, block.until_us), bottom),
    ]
}
