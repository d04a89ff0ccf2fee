//! Smooth motion of one axis as an offset from where it started.

use std::f64::consts::TAU;

use super::draw::Draw;

/// Time in which the amplitude of a swinging path rises and falls.
const RISE_S: f64 = 0.3;

/// Peak speed of a minimum-jerk move over its mean speed.
const PEAK_OVER_MEAN: f64 = 1.875;

/// Shortest minimum-jerk move.
const SHORTEST_MOVE_US: u64 = 150_000;

/// One minimum-jerk move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    from_us: u64,
    until_us: u64,
    distance_counts: f64,
}

/// Motion of one axis between two instants; at rest before and behind.
#[derive(Debug, Clone, PartialEq)]
pub enum Path {
    /// Two sines under an envelope that rises and falls smoothly.
    Swing {
        /// Begin.
        from_us: u64,
        /// End, back at the start.
        until_us: u64,
        /// Amplitude in command counts and frequency in Hz.
        parts: [(f64, f64); 2],
    },
    /// Minimum-jerk moves, one behind the other.
    Moves(Vec<Move>),
}

impl Path {
    /// A path from `from_us` to `until_us` whose steps stay below about `most_counts` a millisecond.
    pub(super) fn draw(draw: &mut Draw, from_us: u64, until_us: u64, most_counts: f64) -> Self {
        if draw.chance(50) {
            Self::draw_swing(draw, from_us, until_us, most_counts)
        } else {
            Self::draw_moves(draw, from_us, until_us, most_counts)
        }
    }

    fn draw_swing(draw: &mut Draw, from_us: u64, until_us: u64, most_counts: f64) -> Self {
        let mut part = || {
            let hertz = draw.real(0.3, 4.0);
            let speed_per_count = TAU * hertz + PEAK_OVER_MEAN / RISE_S;
            (most_counts * 1_000.0 / 2.0 / speed_per_count, hertz)
        };
        let parts = [part(), part()];
        Self::Swing {
            from_us,
            until_us,
            parts,
        }
    }

    fn draw_moves(draw: &mut Draw, from_us: u64, until_us: u64, most_counts: f64) -> Self {
        let mut moves = Vec::new();
        let mut at_us = from_us;
        while at_us + SHORTEST_MOVE_US <= until_us {
            let longest_us = (until_us - at_us).min(800_000);
            let length_us = draw.between(SHORTEST_MOVE_US, longest_us);
            let peak = most_counts * draw.real(0.3, 1.0) / PEAK_OVER_MEAN;
            let sign = draw.pick(&[1.0, -1.0]);
            moves.push(Move {
                from_us: at_us,
                until_us: at_us + length_us,
                distance_counts: sign * peak * length_us as f64 / 1_000.0,
            });
            at_us += length_us + draw.between(0, 100_000);
        }
        Self::Moves(moves)
    }

    /// The offset at an instant, in command counts.
    pub fn at(&self, t_us: u64) -> i32 {
        let counts = match self {
            Self::Swing {
                from_us,
                until_us,
                parts,
            } => swing(*from_us, *until_us, parts, t_us),
            Self::Moves(moves) => moves
                .iter()
                .map(|step| {
                    let length_us = (step.until_us - step.from_us) as f64;
                    let passed_us = t_us.saturating_sub(step.from_us) as f64;
                    step.distance_counts * smooth(passed_us / length_us)
                })
                .sum(),
        };
        counts.round() as i32
    }
}

fn swing(from_us: u64, until_us: u64, parts: &[(f64, f64); 2], t_us: u64) -> f64 {
    if t_us <= from_us || t_us >= until_us {
        return 0.0;
    }
    let (since_s, left_s) = (
        (t_us - from_us) as f64 * 1e-6,
        (until_us - t_us) as f64 * 1e-6,
    );
    let envelope = smooth(since_s / RISE_S) * smooth(left_s / RISE_S);
    let sum: f64 = parts
        .iter()
        .map(|(counts, hertz)| counts * (TAU * hertz * since_s).sin())
        .sum();
    envelope * sum
}

/// Minimum-jerk course from 0 to 1.
fn smooth(share: f64) -> f64 {
    let u = share.clamp(0.0, 1.0);
    u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_stay_below_the_limit_and_the_ends_are_at_rest() {
        for seed in 0..50 {
            let path = Path::draw(&mut Draw::new(seed), 300_000, 1_500_000, 40.0);
            let at = |ms: u64| path.at(ms * 1_000);
            let largest = (1..2_000).map(|ms| (at(ms) - at(ms - 1)).abs()).max();
            assert!(largest <= Some(42) && largest >= Some(5), "{largest:?}");
            assert_eq!((at(0), at(300), at(1_500)), (0, 0, at(1_900)));
        }
    }
}
