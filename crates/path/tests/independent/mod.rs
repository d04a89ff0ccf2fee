//! A judge of paths that shares nothing with the generator: finite differences of the positions, in double precision, and the distance
//! to the ideal geometry.
#![allow(dead_code)]

/// The ideal path: straight lines and arcs, as points close to each other.
pub(crate) struct Ideal {
    pub(crate) points: Vec<[f64; 3]>,
}

impl Ideal {
    pub(crate) fn at(start: [f64; 3]) -> Self {
        Self {
            points: vec![start],
        }
    }

    pub(crate) fn line(&mut self, end: [f64; 3]) {
        self.points.push(end);
    }

    /// An arc in the plane of the first two coordinates, `sweep` in turns, in 20,000 chords a turn and at least 100.
    pub(crate) fn arc(&mut self, centre: [f64; 2], sweep: f64, end: [f64; 3]) {
        let start = *self.points.last().unwrap();
        let (x, y) = (start[0] - centre[0], start[1] - centre[1]);
        let (radius, from) = (x.hypot(y), y.atan2(x));
        let steps = (sweep.abs() * 20_000.0).ceil().max(100.0) as usize;
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            let angle = from + share * sweep * core::f64::consts::TAU;
            self.points.push([
                centre[0] + radius * angle.cos(),
                centre[1] + radius * angle.sin(),
                start[2] + share * (end[2] - start[2]),
            ]);
        }
    }

    /// The largest distance of points in order from this path, which is searched from where the point before was nearest.
    pub(crate) fn deviation(&self, points: &[[f64; 3]]) -> f64 {
        let mut nearest = 0;
        let mut largest = 0.0_f64;
        for point in points {
            let mut best = f64::MAX;
            let mut ahead = 0.0;
            let mut place = nearest;
            for (index, pair) in self.points.windows(2).enumerate().skip(nearest) {
                let distance = to_segment(*point, pair[0], pair[1]);
                if distance < best {
                    best = distance;
                    place = index;
                }
                ahead += between(pair[0], pair[1]);
                if ahead > SEARCHED && index > nearest + 2 {
                    break;
                }
            }
            nearest = place;
            largest = largest.max(best);
        }
        largest
    }
}

/// How far ahead the nearest point is searched, in units: less than a turn of a tiny spiral has room for is not needed by any speed.
const SEARCHED: f64 = 2_000.0;

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
