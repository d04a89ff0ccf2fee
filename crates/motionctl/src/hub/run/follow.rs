//! Wheels that follow targets, cycle by cycle, until there are no more.

use can_motion::wheel::WheelMaster;
use zlac8030l::NodeId;

use super::summary::Counts;
use crate::hub::error::HubError;
use crate::hub::look::Look;
use crate::hub::station::{MOST_WHEELS, WheelStation};
use crate::interrupt;

/// Time for the wheels to stand at the end.
const REST_US: u64 = 3_000_000;

/// Wheels in the order of the columns or sides, with their places in the master, which wants ascending nodes.
#[derive(Debug, Clone)]
pub(super) struct Wheels {
    pub(super) looks: Vec<Look>,
    places: Vec<usize>,
}

impl Wheels {
    /// The places of these wheels.
    pub(super) fn new(looks: Vec<Look>) -> Self {
        let place = |look: &Look| looks.iter().filter(|other| other.node < look.node).count();
        Self {
            places: looks.iter().map(place).collect(),
            looks,
        }
    }

    /// The nodes in the order of the columns.
    pub(super) fn nodes(&self) -> Vec<NodeId> {
        self.looks.iter().map(|look| look.node).collect()
    }

    /// The place in the master of each wheel.
    pub(super) fn places(&self) -> &[usize] {
        &self.places
    }

    /// The wheels in the order of the master.
    pub(super) fn ascending(&self) -> Vec<&Look> {
        let mut looks: Vec<&Look> = self.looks.iter().collect();
        looks.sort_by_key(|look| look.node);
        looks
    }

    /// Sets the target of each wheel.
    pub(super) fn set(&self, master: &mut WheelMaster<MOST_WHEELS>, targets: &[i32]) {
        for (&place, &target) in self.places.iter().zip(targets) {
            // Refused after a fault, which is looked for after each cycle.
            let _ = master.set_target(place, target);
        }
    }

    /// The position of each wheel; none while one was not read.
    pub(super) fn positions(&self, station: &WheelStation<'_>) -> Option<Vec<i32>> {
        let wheels: Vec<_> = station.snapshots().collect();
        let position = |place: &usize| {
            let feedback = wheels.get(*place)?.feedback;
            Some(feedback.position_counts?.value)
        };
        self.places.iter().map(position).collect()
    }

    /// Every wheel stands, by its own report.
    fn stand(&self, station: &WheelStation<'_>) -> bool {
        station.snapshots().all(|wheel| {
            let speed = wheel.feedback.speed_decirpm.map(|read| read.value);
            wheel.sent == 0 && speed == Some(0)
        })
    }
}

/// What each cycle does.
pub(super) trait Motion {
    /// The targets of the cycle that begins; none at the end.
    fn targets(&mut self, now_us: u64, cycle: u64) -> Option<Vec<i32>>;

    /// The cycle is over.
    ///
    /// # Errors
    /// What ends the motion.
    fn note(&mut self, station: &WheelStation<'_>, wheels: &Wheels) -> Result<(), HubError>;
}

/// Brings the wheels up and lets them follow. Returns whether the user has stopped them.
///
/// # Errors
/// The first fault, the link's, or the motion's own.
pub(super) fn follow(
    station: &mut WheelStation<'_>,
    wheels: &Wheels,
    motion: &mut dyn Motion,
) -> Result<Counts, HubError> {
    station.bring_up()?;
    motion.note(station, wheels)?;
    if let Some(recorder) = station.recorder() {
        recorder.bus().motion_begins();
    }
    let mut first = None;
    let mut is_over = false;
    while !is_over && interrupt::requests() == 0 {
        let now_us = station.now().as_us();
        station.cycle(|master, number| {
            let cycle = number - *first.get_or_insert(number);
            match motion.targets(now_us, cycle) {
                Some(targets) => wheels.set(master, &targets),
                None => is_over = true,
            }
        })?;
        after_cycle(station, wheels, motion)?;
    }
    let interrupted = interrupt::requests() > 0;
    if let Some(recorder) = station.recorder() {
        recorder.bus().phase(if interrupted {
            "stopped by the user"
        } else {
            "the motion ends"
        });
    }
    station.come_to_rest()?;
    let start = station.now();
    while !wheels.stand(station) && station.now().us_since(start) < REST_US {
        station.cycle(|_, _| {})?;
        after_cycle(station, wheels, motion)?;
    }
    // The positions of the standstill come with the next feedback.
    for _ in 0..SETTLING_CYCLES {
        station.cycle(|_, _| {})?;
        after_cycle(station, wheels, motion)?;
    }
    let pace = station.pace();
    Ok(Counts {
        interrupted,
        stands: wheels.stand(station),
        cycles: pace.cycles,
        late_cycles: pace.late,
        merged_cycles: pace.merged,
    })
}

/// Cycles that bring a feedback of the drives' timers after standstill.
const SETTLING_CYCLES: u32 = 10;

fn after_cycle(
    station: &mut WheelStation<'_>,
    wheels: &Wheels,
    motion: &mut dyn Motion,
) -> Result<(), HubError> {
    if let Some((node, fault)) = station.first_fault() {
        return Err(HubError::WheelFault { node, fault });
    }
    motion.note(station, wheels)
}
