//! A judge of paths that shares nothing with the generator: finite differences of the positions, in double precision, and the distance
//! to the ideal geometry.
#![allow(dead_code)]

/// A piece of the ideal path.
enum Piece {
    Line([f64; 3], [f64; 3]),
    /// In the plane of the first two coordinates: start, end, centre, radius, first angle, and sweep in radians.
    Arc([f64; 3], [f64; 3], [f64; 2], f64, f64, f64),
}

/// The ideal path.
pub(crate) struct Ideal {
    pieces: Vec<Piece>,
    pub(crate) end: [f64; 3],
}

/// Pieces before and behind the best one that a point may belong to.
const BAND: usize = 40;

impl Ideal {
    pub(crate) fn at(start: [f64; 3]) -> Self {
        Self {
            pieces: Vec::new(),
            end: start,
        }
    }

    pub(crate) fn line(&mut self, end: [f64; 3]) {
        self.pieces.push(Piece::Line(self.end, end));
        self.end = end;
    }

    /// An arc in the plane of the first two coordinates, `sweep` in turns.
    pub(crate) fn arc(&mut self, centre: [f64; 2], sweep: f64, end: [f64; 3]) {
        let (x, y) = (self.end[0] - centre[0], self.end[1] - centre[1]);
        let sweep = sweep * core::f64::consts::TAU;
        self.pieces.push(Piece::Arc(
            self.end,
            end,
            centre,
            x.hypot(y),
            y.atan2(x),
            sweep,
        ));
        self.end = end;
    }

    /// The largest distance of points from this path when they are matched with its pieces in order, in the best way to do that.
    pub(crate) fn deviation(&self, points: &[[f64; 3]]) -> f64 {
        // For each piece: the largest distance so far, when this point belongs to it.
        let mut matched = vec![f64::MAX; self.pieces.len()];
        matched[0] = 0.0;
        let mut nearest = 0_usize;
        for point in points {
            let first = nearest.saturating_sub(BAND);
            let last = (nearest + BAND).min(self.pieces.len() - 1);
            let mut before = f64::MAX;
            for index in first..=last {
                before = before.min(matched[index]);
                matched[index] = before.max(self.pieces[index].distance(*point));
                if matched[index] < matched[nearest] || index == first {
                    nearest = index;
                }
            }
        }
        matched.into_iter().fold(f64::MAX, f64::min)
    }
}

impl Piece {
    fn distance(&self, point: [f64; 3]) -> f64 {
        match self {
            Self::Line(from, to) => to_segment(point, *from, *to),
            Self::Arc(from, to, centre, radius, first, sweep) => {
                let (x, y) = (point[0] - centre[0], point[1] - centre[1]);
                let ends = between(point, *from).min(between(point, *to));
                let whole = core::f64::consts::TAU;
                let turned = (y.atan2(x) - first) * sweep.signum();
                let mut best = ends;
                let mut angle = turned.rem_euclid(whole);
                while angle <= sweep.abs() {
                    let z = from[2] + (to[2] - from[2]) * angle / sweep.abs();
                    let across = (x.hypot(y) - radius).hypot(point[2] - z);
                    best = best.min(across);
                    angle += whole;
                }
                best
            }
        }
    }
}

fn between(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3)
        .map(|axis| (a[axis] - b[axis]).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn to_segment(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let way: Vec<f64> = (0..3).map(|axis| to[axis] - from[axis]).collect();
    let square: f64 = way.iter().map(|part| part * part).sum();
    let along: f64 = (0..3)
        .map(|axis| (point[axis] - from[axis]) * way[axis])
        .sum();
    let share = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let foot = [0, 1, 2].map(|axis| from[axis] + share * way[axis]);
    between(point, foot)
}

/// The largest velocity, acceleration and jerk of an axis as finite differences over `stride` cycles, per cycle.
pub(crate) fn derivatives(positions: &[f64], stride: usize) -> [(f64, isize); 3] {
    let at = |index: isize| {
        let last = positions.len() as isize - 1;
        positions[index.clamp(0, last) as usize]
    };
    let (h, step) = (stride as f64, stride as isize);
    let mut largest = [(0.0_f64, 0); 3];
    for index in -3 * step..positions.len() as isize {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| at(index + k * step));
        let differences = [
            (b - a) / h,
            (c - 2.0 * b + a) / (h * h),
            (d - 3.0 * c + 3.0 * b - a) / (h * h * h),
        ];
        for (largest, difference) in largest.iter_mut().zip(differences) {
            if difference.abs() > largest.0 {
                *largest = (difference.abs(), index);
            }
        }
    }
    largest
}

/// Refuses what exceeds the limits by more than `rounding` counts of each position explain. Returns the largest shares.
pub(crate) fn judge(name: &str, axes: &[Vec<f64>], limits: &[[f64; 3]], rounding: f64) -> [f64; 3] {
    let mut shares = [0.0_f64; 3];
    for (axis, (positions, limits)) in axes.iter().zip(limits).enumerate() {
        for stride in [1, 2, 4, 8, 16, 32] {
            let h = stride as f64;
            let allowed = [
                2.0 * rounding / h,
                4.0 * rounding / (h * h),
                8.0 * rounding / (h * h * h),
            ];
            let actual = derivatives(positions, stride);
            for order in 0..3 {
                assert!(
                    actual[order].0 <= limits[order] + allowed[order],
                    "{name}: axis {axis}, of {} cycles at {}, derivative {} over {stride} cycles is {}, the limit {}",
                    positions.len(),
                    actual[order].1,
                    order + 1,
                    actual[order].0,
                    limits[order]
                );
                shares[order] = shares[order].max(actual[order].0 / limits[order]);
            }
        }
    }
    shares
}
