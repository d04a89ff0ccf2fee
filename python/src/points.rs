//! Set-points with times, checked, and the segments between them.

use board_link::segment::{AxisSegment, OfAxes, Segment, Shape};
use trajectory::{Position, Time};

/// Counts that a position can be.
const MOST_COUNTS: f64 = (1_u64 << 31) as f64;
/// Cycles that a motion can last: 24 days at 1 kHz.
const MOST_CYCLES: f64 = (1_u64 << 31) as f64;
/// Units of a tick and of a position, as numbers.
const TICKS: f64 = (1_u64 << 32) as f64;
const UNITS: f64 = Position::UNITS as f64;

/// Where every axis is at a time since the start.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    pub(crate) time: Time,
    pub(crate) positions: Vec<Position>,
}

impl Point {
    /// From a time in cycles and positions in counts; the error says which value is none.
    pub(crate) fn of(cycles: f64, counts: &[f64]) -> Result<Self, String> {
        if !(0.0..MOST_CYCLES).contains(&cycles) {
            return Err(format!(
                "the time: expected 0 to {MOST_CYCLES} cycles, got {cycles}"
            ));
        }
        let mut positions = Vec::with_capacity(counts.len());
        for (axis, &counts) in counts.iter().enumerate() {
            // What is no number is not within.
            if !(-MOST_COUNTS..MOST_COUNTS).contains(&counts) {
                return Err(format!(
                    "axis {axis}: expected a position of -2^31 to 2^31 counts, got {counts}"
                ));
            }
            positions.push(Position::from_units((counts * UNITS).round() as i64));
        }
        let time = Time::from_ticks((cycles * TICKS).round() as u64);
        Ok(Self { time, positions })
    }
}

/// Velocity in counts per cycle and acceleration in counts per cycle².
#[derive(Debug, Clone, Copy, Default)]
struct Slope {
    velocity: f64,
    acceleration: f64,
}

/// Makes segments of set-points: curves of fifth degree, at rest at the first and at the last one. Velocity and acceleration in between are
/// those of the parabola through a set-point and its neighbours, so neither has a step.
pub(crate) struct SegmentMaker {
    from: Point,
    leaving: Vec<Slope>,
    to: Option<Point>,
}

impl SegmentMaker {
    /// At rest at the first set-point.
    pub(crate) fn new(first: Point) -> Self {
        let leaving = vec![Slope::default(); first.positions.len()];
        Self {
            from: first,
            leaving,
            to: None,
        }
    }

    /// The latest set-point.
    pub(crate) fn latest(&self) -> &Point {
        self.to.as_ref().unwrap_or(&self.from)
    }

    /// Takes the next set-point; the segment that it completes is the one before it.
    pub(crate) fn push(&mut self, next: Point) -> Option<Segment> {
        let Some(to) = self.to.take() else {
            self.to = Some(next);
            return None;
        };
        let axes = 0..to.positions.len();
        let arriving = axes
            .map(|axis| slope(&self.from, &to, &next, axis))
            .collect();
        let segment = self.segment(&to, &arriving);
        (self.from, self.leaving, self.to) = (to, arriving, Some(next));
        Some(segment)
    }

    /// The last segment, which ends at rest; nothing after a single set-point.
    pub(crate) fn finish(&mut self) -> Option<Segment> {
        let to = self.to.take()?;
        let arriving = vec![Slope::default(); to.positions.len()];
        Some(self.segment(&to, &arriving))
    }

    fn segment(&self, to: &Point, arriving: &Vec<Slope>) -> Segment {
        let duration = to.time.since(self.from.time);
        let cycles = duration.ticks() as f64 / TICKS;
        let units = |slope: &Slope| {
            let velocity = slope.velocity * cycles * UNITS;
            let acceleration = slope.acceleration * cycles * cycles / 2.0 * UNITS;
            (velocity.round() as i64, acceleration.round() as i64)
        };
        let axes = to.positions.iter().zip(&self.leaving).zip(arriving);
        let axes: OfAxes<AxisSegment> = axes
            .map(|((end, leaving), arriving)| {
                let (leaving, leaving_acceleration) = units(leaving);
                let (arriving, arriving_acceleration) = units(arriving);
                AxisSegment {
                    end: end.units(),
                    shape: Shape::Quintic {
                        leaving,
                        leaving_acceleration,
                        arriving,
                        arriving_acceleration,
                    },
                }
            })
            .collect();
        Segment {
            duration: duration.ticks(),
            axes,
        }
    }
}

/// Mean velocity from one set-point to the next, and the cycles between them.
fn chord(from: &Point, to: &Point, axis: usize) -> (f64, f64) {
    let cycles = to.time.since(from.time).ticks() as f64 / TICKS;
    let at = |point: &Point| {
        point
            .positions
            .get(axis)
            .map_or(0, |position| position.units())
    };
    // The difference of two positions of 2^31 counts fits.
    let way = (at(to) - at(from)) as f64 / UNITS;
    (way / cycles, cycles)
}

fn slope(before: &Point, here: &Point, after: &Point, axis: usize) -> Slope {
    let ((first, left), (second, right)) = (chord(before, here, axis), chord(here, after, axis));
    Slope {
        velocity: (first * right + second * left) / (left + right),
        acceleration: 2.0 * (second - first) / (left + right),
    }
}
