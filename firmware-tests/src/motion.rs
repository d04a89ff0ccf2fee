//! An image with its drives, standing or moving: what `cargo xtask cost` and `cargo xtask profile` count.

use drive_sim::{DynDrive, DynDriveConfig, ResponseDelay};

use crate::image::Image;
use crate::rig::{Contact, Rig};

/// Each reply takes its time by up to this share more or less, in percent: no drive answers always alike.
const SPREAD_PERCENT: u64 = 25;
/// Longest time from power-on, and from enable, until every drive gets set-points: many axes on a full bus begin late.
const PATIENCE_MS: u64 = 5_000;
/// Until the drives are known, and until what belongs to the start or to the beginning of the motion is over.
const FOUND_MS: u64 = 400;
const SETTLED_MS: u64 = 1_000;

/// Drives and how long they take to answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Drives {
    /// How many, with the ids from 1.
    pub count: i32,
    /// Time from the end of a request to its reply in microseconds, each time more or less by up to a quarter.
    pub response_us: u64,
}

impl Drives {
    pub(crate) fn config(self, id: i32) -> DynDriveConfig {
        let of_response = |percent: u64| self.response_us * 1_000 * percent / 100;
        let (least, most) = (100 - SPREAD_PERCENT, 100 + SPREAD_PERCENT);
        let delay = ResponseDelay::between(of_response(least), of_response(most));
        DynDriveConfig {
            response_delay: delay.expect("the least is not more than the most"),
            seed: id as u64,
            ..DynDriveConfig::numbered(id).expect("an id is 1 to 63")
        }
    }
}

/// A board whose axes are enabled and hold their positions.
///
/// # Errors
/// When a drive gets no set-points, with the log.
pub fn standing(image: Image, drives: Drives) -> Result<Rig, String> {
    let mut rig = Rig::with_drives(image, (1..=drives.count).map(|id| drives.config(id)));
    rig.close(Contact::Stop);
    rig.run_ms(FOUND_MS);
    rig.close(Contact::Enable);
    let begun = (0..PATIENCE_MS).any(|_| {
        rig.run_ms(1);
        let streams = |drive: &DynDrive| drive.is_enabled() && drive.books().pd_frames > 0;
        rig.servos().all(streams)
    });
    if !begun {
        return Err(format!(
            "not every drive got set-points within {PATIENCE_MS} ms; the log: {:#?}",
            rig.board().log()
        ));
    }
    rig.run_ms(SETTLED_MS);
    Ok(rig)
}

/// Lets the axes of a board that holds them move.
pub fn set_moving(rig: &mut Rig) {
    rig.close(Contact::Run);
    rig.run_ms(SETTLED_MS);
}

/// What a millisecond takes: each is one cycle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Milliseconds {
    /// Milliseconds counted.
    pub count: u64,
    /// Instructions altogether.
    pub instructions: u64,
    /// The most instructions in one.
    pub worst: u64,
    /// The most instructions in one in which no line of the log was written.
    pub worst_without_line: u64,
}

impl Milliseconds {
    /// Counts so many milliseconds, in each of which `run` lets one pass.
    pub fn count(rig: &mut Rig, count: u64, mut run: impl FnMut(&mut Rig)) -> Self {
        let each: Vec<(u64, bool)> = (0..count)
            .map(|_| {
                let (instructions, lines) =
                    (rig.board().soc().instructions, rig.board().log().len());
                run(rig);
                (
                    rig.board().soc().instructions - instructions,
                    rig.board().log().len() > lines,
                )
            })
            .collect();
        Self::of(&each)
    }

    /// Instructions of each millisecond, and whether a line of the log was complete in it: it may have begun in the one before.
    fn of(each: &[(u64, bool)]) -> Self {
        let next = each.iter().skip(1).map(|&(_, line)| line).chain([false]);
        let quiet = each
            .iter()
            .zip(next)
            .filter(|((_, line), next)| !line && !next);
        Self {
            count: each.len() as u64,
            instructions: each.iter().map(|(instructions, _)| instructions).sum(),
            worst: each
                .iter()
                .map(|&(instructions, _)| instructions)
                .max()
                .unwrap_or(0),
            worst_without_line: quiet
                .map(|(&(instructions, _), _)| instructions)
                .max()
                .unwrap_or(0),
        }
    }

    /// Instructions of a millisecond on average.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.instructions as f64 / self.count.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_counts_for_the_millisecond_of_its_end_and_the_one_before() {
        let counted =
            Milliseconds::of(&[(5, false), (6, false), (9, false), (8, true), (7, false)]);
        assert_eq!(
            counted,
            Milliseconds {
                count: 5,
                instructions: 35,
                worst: 9,
                worst_without_line: 7,
            }
        );
        assert!((counted.mean() - 7.0).abs() < f64::EPSILON);
    }

    #[test]
    fn every_drive_answers_within_its_spread_and_differently() {
        let drives = Drives {
            count: 2,
            response_us: 800,
        };
        let (first, second) = (drives.config(1), drives.config(2));
        assert_eq!(first.response_delay.min_ns(), 600_000);
        assert_eq!(first.response_delay.max_ns(), 1_000_000);
        assert_ne!(first.seed, second.seed);
    }
}
