//! Steps whose set-points have two bytes: those that are longest on the wire, or random ones.

use drive_sim::{Frame, SplitMix64, WireLength};
use dyn_can::{DriveId, PdStep, Revision, go_relative_pos_pd};

/// Largest step of the protocol.
const MAX_STEP: i32 = 16_384;

/// What the set-points of an axis carry.
#[derive(Debug, Clone)]
pub(crate) struct Payload {
    forward: Vec<i32>,
    backward: Vec<i32>,
}

impl Payload {
    /// Every step of two bytes.
    pub(crate) fn random(drive: DriveId) -> Self {
        Self::of(two_bytes(drive).map(|(step, _)| step))
    }

    /// The steps whose frames are longest on the wire.
    pub(crate) fn worst(drive: DriveId) -> Self {
        let longest = two_bytes(drive).map(|(_, bits)| bits).max();
        let is_longest = |(step, bits)| (Some(bits) == longest).then_some(step);
        Self::of(two_bytes(drive).filter_map(is_longest))
    }

    fn of(steps: impl Iterator<Item = i32>) -> Self {
        let (forward, backward) = steps.partition(|step| *step > 0);
        Self { forward, backward }
    }

    /// The next step, towards the origin where there is a choice, so that an axis can go on for ever.
    pub(crate) fn step(&self, position_counts: i32, random: &mut SplitMix64) -> i32 {
        let wanted = if position_counts > 0 {
            [&self.backward, &self.forward]
        } else {
            [&self.forward, &self.backward]
        };
        let steps = wanted.into_iter().find(|steps| !steps.is_empty());
        steps.map_or(0, |steps| {
            steps[random.up_to(steps.len() as u64 - 1) as usize]
        })
    }
}

/// Steps with two bytes, each with the bits of its frame, interframe space included.
fn two_bytes(drive: DriveId) -> impl Iterator<Item = (i32, u32)> {
    (-MAX_STEP..=MAX_STEP).filter_map(move |step| {
        let order = dyn_can::Dialect::of(Revision::V1_6A).number_order;
        let frame = go_relative_pos_pd(drive, PdStep::new(step).ok()?, order);
        let frame: Frame = (frame.len() == 2).then(|| frame.to_can())??;
        Some((step, WireLength::of(&frame).bits_with_ifs))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::MOST_CYCLES;
    use crate::limits::stand::START_COUNTS;

    /// The plan takes every payload for possible; the longest of all may be beyond the steps of the protocol, by a bit or two.
    #[test]
    fn the_longest_set_points_are_as_long_as_the_plan_says_or_nearly() {
        let mut missing_bits = 0;
        for drive in DriveId::all().take(14) {
            let longest = two_bytes(drive).map(|(_, bits)| bits).max();
            let id = drive.can_id(dyn_can::FunctionCode::GoRelativePosPd);
            let planned = u32::from(can_motion::plan::wire::worst_bits(id, 2));
            let longest = longest.expect("steps of two bytes");
            assert!(longest <= planned, "drive {drive}");
            missing_bits += planned - longest;
        }
        assert_eq!(missing_bits, 2);
    }

    /// The only longest set-points of some drives all go in one direction.
    #[test]
    fn an_axis_that_steps_for_the_longest_run_stays_within_its_travel() {
        let travel = dyn_can::Counts28::MIN.get()..=dyn_can::Counts28::MAX.get();
        for drive in DriveId::all().take(14) {
            let (payload, mut random) = (Payload::worst(drive), SplitMix64::new(1));
            let mut position = 0_i32;
            for _ in 0..MOST_CYCLES {
                position += payload.step(position, &mut random);
                assert!(travel.contains(&(START_COUNTS + position)), "drive {drive}");
            }
        }
    }
}
