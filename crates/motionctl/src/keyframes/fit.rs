//! Keyframes, and velocities in them, whose cubics stay near a path.

use trajectory::curve::{Keyframe, KeyframeError, KeyframeMotion};

use super::error::KeyframesError;

/// The longest way from one keyframe to the next, in places where one can be.
const LONGEST: usize = 4_096;
const MS_PER_S: f64 = 1_000.0;
const US_PER_MS: u32 = 1_000;
/// What a velocity in whole counts per second is away from the exact one, and the arithmetic of the board, in counts.
const ARITHMETIC_COUNTS: f64 = 0.02;

/// Positions of every motor at every cycle, in counts, not rounded.
pub(crate) type Rows = [Vec<f64>];

/// Keyframes, and how far from the path the board is with them.
#[derive(Debug)]
pub(super) struct Fitted {
    pub(super) frames: Vec<Frame>,
    /// Between the set-points of the board and those of the path, both in whole counts.
    pub(super) worst_counts: u64,
    /// Largest step of each motor in a cycle.
    pub(super) steps: Vec<u64>,
    pub(super) motors: usize,
}

/// One keyframe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) at_ms: u32,
    pub(super) counts: Vec<i32>,
    pub(super) counts_per_s: Vec<i32>,
}

/// What the places of keyframes depend on.
struct Path<'a> {
    rows: &'a Rows,
    cycle_us: u32,
    /// Cycles from one place where a keyframe can be to the next: whole milliseconds.
    stride: usize,
    tolerance: f64,
}

impl Fitted {
    /// As few keyframes as are found by going as far as possible with each.
    pub(super) fn new(
        rows: &Rows,
        cycle_us: u32,
        tolerance_counts: f64,
    ) -> Result<Self, KeyframesError> {
        let cycles = (1..).find(|cycles: &u32| (cycles * cycle_us).is_multiple_of(US_PER_MS));
        let path = Path {
            rows,
            cycle_us,
            stride: cycles.unwrap_or(US_PER_MS) as usize,
            tolerance: tolerance_counts - ARITHMETIC_COUNTS,
        };
        let last = (rows.len() - 1).div_ceil(path.stride).max(1) * path.stride;
        let mut frames = vec![path.frame(0)];
        let mut from = 0;
        while from < last {
            let Some(to) = path.farthest(from, last) else {
                return Err(KeyframesError::Tolerance {
                    at_ms: path.ms(from).into(),
                    tolerance_counts,
                });
            };
            frames.push(path.frame(to));
            from = to;
        }
        // Nothing moves at the ends.
        let motors = rows.first().map_or(0, Vec::len);
        if let [first, .., end] = &mut frames[..] {
            first.counts_per_s = vec![0; motors];
            end.counts_per_s = vec![0; motors];
        }
        let mut fitted = Self {
            frames,
            worst_counts: 0,
            steps: Vec::new(),
            motors,
        };
        for motor in 0..motors {
            fitted.measure(motor, rows, cycle_us)?;
        }
        Ok(fitted)
    }

    /// Plays a motor as the board does.
    fn measure(&mut self, motor: usize, rows: &Rows, cycle_us: u32) -> Result<(), KeyframeError> {
        let keyframes: Vec<Keyframe<1>> = self
            .frames
            .iter()
            .map(|frame| Keyframe {
                at_ms: frame.at_ms,
                positions_counts: [frame.counts[motor]],
            })
            .collect();
        let velocities: Vec<[i32; 1]> = self
            .frames
            .iter()
            .map(|frame| [frame.counts_per_s[motor]])
            .collect();
        let motion = KeyframeMotion::passing(&keyframes, &velocities)?;
        let (mut before, mut largest) = (0_i32, 0);
        for (row, cycle) in rows.iter().zip(0_u64..) {
            let [at] = motion.position(cycle * u64::from(cycle_us));
            let exact = row[motor].round() as i32;
            self.worst_counts = self.worst_counts.max(u64::from(at.abs_diff(exact)));
            largest = largest.max(u64::from(at.abs_diff(before)));
            before = at;
        }
        self.steps.push(largest);
        Ok(())
    }

    pub(super) fn duration_ms(&self) -> u32 {
        self.frames.last().map_or(0, |frame| frame.at_ms)
    }

    /// In the flash of the board: a time, and a position and a velocity of each motor, in 32 bits.
    pub(super) fn bytes(&self) -> usize {
        self.frames.len() * (1 + 2 * self.motors) * size_of::<u32>()
    }
}

impl Path<'_> {
    fn ms(&self, cycle: usize) -> u32 {
        (cycle as u64 * u64::from(self.cycle_us) / u64::from(US_PER_MS)) as u32
    }

    fn row(&self, cycle: usize) -> &[f64] {
        &self.rows[cycle.min(self.rows.len() - 1)]
    }

    fn frame(&self, cycle: usize) -> Frame {
        let per_s = 1e6 / f64::from(self.cycle_us);
        let (before, after) = (self.row(cycle.saturating_sub(1)), self.row(cycle + 1));
        Frame {
            at_ms: self.ms(cycle),
            counts: self.row(cycle).iter().map(|at| at.round() as i32).collect(),
            counts_per_s: before
                .iter()
                .zip(after)
                .map(|(before, after)| (0.5 * (after - before) * per_s).round() as i32)
                .collect(),
        }
    }

    /// The farthest cycle that the way from another one reaches within the tolerance, found by doubling and halving.
    fn farthest(&self, from: usize, last: usize) -> Option<usize> {
        let most = ((last - from) / self.stride).min(LONGEST);
        let at = |steps: usize| from + steps * self.stride;
        let is_near = |steps: usize| self.is_near(from, at(steps));
        if !is_near(1) {
            return None;
        }
        let mut near = 1;
        while near < most && is_near((2 * near).min(most)) {
            near = (2 * near).min(most);
        }
        let mut far = (2 * near).min(most + 1);
        while far - near > 1 {
            let middle = usize::midpoint(near, far);
            if is_near(middle) {
                near = middle;
            } else {
                far = middle;
            }
        }
        Some(at(near))
    }

    fn is_near(&self, from: usize, to: usize) -> bool {
        let (start, end) = (self.frame(from), self.frame(to));
        let duration_s = f64::from(end.at_ms - start.at_ms) / MS_PER_S;
        (from..=to).all(|cycle| {
            let u = (cycle - from) as f64 / (to - from) as f64;
            let motors = self.row(cycle).iter().enumerate();
            motors.into_iter().all(|(motor, exact)| {
                let counts = [&start, &end].map(|frame| f64::from(frame.counts[motor]));
                let ways =
                    [&start, &end].map(|frame| f64::from(frame.counts_per_s[motor]) * duration_s);
                (cubic(counts, ways, u) - exact).abs() <= self.tolerance
            })
        })
    }
}

/// The cubic of Hermite at a share of the way.
fn cubic([from, to]: [f64; 2], [leaving, arriving]: [f64; 2], u: f64) -> f64 {
    let way = to - from;
    let square = 3.0 * way - 2.0 * leaving - arriving;
    let cube = leaving + arriving - 2.0 * way;
    from + ((cube * u + square) * u + leaving) * u
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There and back as a cosine: 2000 counts in a second.
    fn wave(cycles: usize) -> Vec<Vec<f64>> {
        let row = |cycle: usize| {
            let angle = core::f64::consts::TAU * cycle as f64 / cycles as f64;
            vec![1_000.0 * (1.0 - angle.cos()), 0.0]
        };
        (0..=cycles).map(row).collect()
    }

    #[test]
    fn keyframes_are_few_and_near() {
        let rows = wave(1_000);
        let fitted = Fitted::new(&rows, 1_000, 1.0).unwrap();
        assert!(
            (5..60).contains(&fitted.frames.len()),
            "{}",
            fitted.frames.len()
        );
        assert!(fitted.worst_counts <= 1, "{}", fitted.worst_counts);
        assert_eq!(fitted.duration_ms(), 1_000);
        assert_eq!(fitted.bytes(), 20 * fitted.frames.len());
        // 6.28 counts in a cycle at most; rounded.
        assert_eq!(fitted.steps, [7, 0]);
        let fewer = Fitted::new(&rows, 1_000, 20.0).unwrap();
        assert!(fewer.frames.len() < fitted.frames.len());
        assert!(fewer.worst_counts > 1 && fewer.worst_counts <= 20);
    }

    #[test]
    fn keyframes_stand_at_whole_milliseconds() {
        for cycle_us in [250, 800, 1_500] {
            let rows = wave(1_001);
            let fitted = Fitted::new(&rows, cycle_us, 1.0).unwrap();
            assert!(
                fitted.worst_counts <= 1,
                "{cycle_us}: {}",
                fitted.worst_counts
            );
            let end_us = fitted.duration_ms() * 1_000;
            assert!((end_us - 1_001 * cycle_us) < 12_000, "{cycle_us}");
        }
    }

    #[test]
    fn a_path_that_no_keyframe_follows_is_refused() {
        // A cycle of 333 us has a whole millisecond every 1000 cycles.
        let error = Fitted::new(&wave(999), 333, 1.0).unwrap_err();
        assert!(error.to_string().starts_with("behind 0 ms"), "{error}");
    }
}
