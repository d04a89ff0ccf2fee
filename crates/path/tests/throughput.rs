//! What a short queue prepares while the tool moves.

mod independent;

use independent::Ideal;
use independent::rig::{LIMITS, Piece, SHORT, Tool, feed_one, tool_with};
use path::Join;

/// Cycles in which the tool stands between its first and its last move.
fn rests(pieces: &[Piece], feed: f32, join: Join) -> usize {
    let mut tool: Tool<SHORT> = tool_with([LIMITS; 3]);
    let mut ideal = Ideal::at([0.0; 3]);
    let mut rest = pieces.iter().peekable();
    let (mut rests, mut has_moved) = (0, false);
    for _ in 0..200_000 {
        if tool.has_room()
            && let Some(piece) = rest.next()
        {
            feed_one(&mut tool, piece, feed, join, &mut ideal);
        }
        tool.advance();
        if rest.peek().is_none() && tool.is_done() {
            break;
        }
        let stands = tool.is_at_rest();
        rests += usize::from(stands && has_moved);
        has_moved |= !stands;
    }
    assert!(tool.is_done());
    rests
}

#[test]
fn pieces_are_prepared_while_the_tool_is_on_the_one_before() {
    let mut arcs = Vec::new();
    for k in 0..12 {
        let (x, turns) = (f64::from(k) * 20_000.0, 0.5 - f64::from(k % 2));
        arcs.push(Piece::Arc(
            [x + 10_000.0, 0.0],
            turns,
            [x + 20_000.0, 0.0, 0.0],
        ));
    }
    assert_eq!(rests(&arcs, 100.0, Join::Blend(50.0)), 0);
    let zigzag = |k| Piece::Line([f64::from(k) * 3_000.0, f64::from(k % 2) * 2_000.0, 0.0]);
    let lines: Vec<Piece> = (1..40).map(zigzag).collect();
    assert_eq!(rests(&lines, 100.0, Join::Blend(50.0)), 0);
    // Quarters of one circle.
    let mut circle = Vec::new();
    for k in 0..12 {
        let angle = f64::from(k + 1) * core::f64::consts::FRAC_PI_2;
        let end = [
            10_000.0 - 10_000.0 * angle.cos(),
            10_000.0 * angle.sin(),
            0.0,
        ];
        circle.push(Piece::Arc([10_000.0, 0.0], -0.25, end));
    }
    assert_eq!(rests(&circle, 60.0, Join::Exact), 0);
}
