//! Centre and sweep of an arc, in double precision.

use trajectory::Position;

use crate::error::ErrorKind;

/// A point of a plane in micrometres.
type Point = [f64; 2];

/// A turn, in 2^-32 of which a sweep is counted.
const TURN: f64 = 4_294_967_296.0;
const UNITS: f64 = Position::UNITS as f64;

/// By how much start and end may differ in their distance from the centre: what programs are rounded to, and a thousandth of the radius.
const LEAST_DIFFERENCE_UM: f64 = 5.0;
const DIFFERENCE_SHARE: f64 = 0.001;
const MOST_DIFFERENCE_UM: f64 = 500.0;

pub(crate) struct Round {
    pub(crate) centre: [Position; 2],
    pub(crate) sweep: i64,
}

pub(crate) fn point(coordinates: [i64; 2]) -> Point {
    coordinates.map(|coordinate| coordinate as f64 / UNITS)
}

/// With the centre at an offset from the start.
pub(crate) fn around(
    start: [i64; 2],
    end: [i64; 2],
    offset: [i64; 2],
    clockwise: bool,
) -> Result<Round, ErrorKind> {
    let centre = [start[0] + offset[0], start[1] + offset[1]];
    let from = point([-offset[0], -offset[1]]);
    let to = point([end[0] - centre[0], end[1] - centre[1]]);
    let (start_um, end_um) = (libm::hypot(from[0], from[1]), libm::hypot(to[0], to[1]));
    let most = (DIFFERENCE_SHARE * start_um).clamp(LEAST_DIFFERENCE_UM, MOST_DIFFERENCE_UM);
    if start_um <= 0.0 || libm::fabs(start_um - end_um) > most {
        return Err(ErrorKind::ArcCentre {
            start_um: start_um as f32,
            end_um: end_um as f32,
        });
    }
    Ok(Round {
        centre: centre.map(Position::from_units),
        sweep: sweep(from, to, start == end, clockwise),
    })
}

/// With a radius; a negative one is that of the longer of both arcs.
pub(crate) fn through(
    start: [i64; 2],
    end: [i64; 2],
    radius: i64,
    clockwise: bool,
) -> Result<Round, ErrorKind> {
    if start == end {
        return Err(ErrorKind::ArcClosed);
    }
    let way = point([end[0] - start[0], end[1] - start[1]]);
    let chord = libm::hypot(way[0], way[1]);
    let (size, is_longer) = (radius.unsigned_abs() as f64 / UNITS, radius < 0);
    let least = 0.5 * chord;
    if size < least - LEAST_DIFFERENCE_UM.min(DIFFERENCE_SHARE * size) {
        return Err(ErrorKind::ArcRadius {
            least_um: least as f32,
            actual_um: size as f32,
        });
    }
    let height = libm::sqrt((size * size - least * least).max(0.0));
    // To the left of the way for the shorter arc counterclockwise.
    let side = if clockwise == is_longer { 1.0 } else { -1.0 };
    let offset = [
        0.5 * way[0] - side * height * way[1] / chord,
        0.5 * way[1] + side * height * way[0] / chord,
    ];
    let centre = [0, 1].map(|place: usize| {
        // Rounded to 2^-24 micrometres.
        start[place].wrapping_add(libm::round(offset[place] * UNITS) as i64)
    });
    // Not from the radii: of a tiny way they are the same, also where nearly a whole turn is between them.
    let shorter = libm::round(2.0 * libm::atan2(least, height) / core::f64::consts::TAU * TURN);
    let turned = if is_longer { TURN - shorter } else { shorter } as i64;
    Ok(Round {
        centre: centre.map(Position::from_units),
        sweep: if clockwise { -turned } else { turned },
    })
}

/// From one radius to another, a whole turn when they are the same.
fn sweep(from: Point, to: Point, is_whole: bool, clockwise: bool) -> i64 {
    let whole = if clockwise { -TURN } else { TURN };
    if is_whole {
        return whole as i64;
    }
    let cross = from[0] * to[1] - from[1] * to[0];
    let dot = from[0] * to[0] + from[1] * to[1];
    let angle = libm::atan2(cross, dot) / core::f64::consts::TAU * TURN;
    let turned = libm::round(angle);
    // In the direction of the arc; two radii in the same direction are a whole turn apart, unless rounding has made them the same.
    let against = if clockwise {
        turned > 0.0
    } else {
        turned < 0.0
    };
    (if against { turned + whole } else { turned }) as i64
}
