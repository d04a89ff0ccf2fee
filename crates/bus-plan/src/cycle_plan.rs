//! Whether a bus carries the frames of its cycles: [`CyclePlan`].

use crate::analysis::Response;
use crate::burst::Burst;
use crate::cycle::{Cycle, RequestPlace, narrow};
use crate::demand::{cycle_of, poll_stretch_permille, usual_burst};
use crate::drive::Drive;
use crate::refusal::{Refusal, Warning};
use crate::remedies::Remedies;
use crate::setup::{CycleSetup, TxOrder};

/// From this identifier on seven recessive bits come first, which CAN 2.0A forbade.
const FIRST_HIGH_ID: u16 = 0x7F0;

/// The worst case of a master that sends a set-point to each drive in each cycle, and whether it is good enough.
#[derive(Debug, Clone, Copy)]
pub struct CyclePlan {
    cycle: Cycle,
    /// Kept, so that a plan made in a `const` needs no table at run time.
    burst: Burst,
    /// When the last request of a cycle is through.
    requests_end_bits: Option<u64>,
    warnings: [Option<Warning>; 2],
    pub(crate) refusal: Option<Refusal>,
    remedies: Remedies,
}

impl CyclePlan {
    /// The same plan with advice.
    pub(crate) const fn with(self, remedies: Remedies) -> Self {
        Self { remedies, ..self }
    }

    /// The plan with or without polls, and no advice.
    pub(crate) const fn of(
        setup: &CycleSetup,
        drives: &[Drive],
        is_polled: bool,
        place: RequestPlace,
    ) -> Self {
        let cycle = cycle_of(setup, drives, is_polled, place);
        let mut plan = Self {
            cycle,
            burst: usual_burst(setup, &cycle),
            requests_end_bits: None,
            warnings: warnings(drives, cycle.requests),
            refusal: Refusal::outright(setup, drives),
            remedies: Remedies::NONE,
        };
        if plan.refusal.is_none() {
            plan.refusal = plan.overload(drives);
        }
        if plan.refusal.is_none() {
            plan.requests_end_bits = cycle.requests_end_bits();
            plan.refusal = plan.late_frame(drives);
        }
        plan
    }

    /// Whether the master may choose the place of the requests among the set-points. A controller that sorts by identifier would
    /// give them back when set-points come behind them.
    #[must_use]
    pub const fn has_room_for_requests(&self) -> bool {
        matches!(
            (self.cycle.order, self.cycle.place),
            (TxOrder::Fifo, RequestPlace::Anywhere)
        ) && self.cycle.requests > 0
    }

    /// The usual times on the wire.
    #[must_use]
    pub const fn burst(&self) -> Burst {
        self.burst
    }

    /// Whether every frame is in time.
    ///
    /// # Errors
    /// [`Refusal`] with the first frame that is not, or with what cannot be on one bus at all.
    pub const fn check(&self) -> Result<(), Refusal> {
        match self.refusal {
            Some(refusal) => Err(refusal),
            None => Ok(()),
        }
    }

    /// Makes a `const` that is not schedulable fail to compile, with the frame, its response, its deadline and what would help in the
    /// message.
    ///
    /// # Panics
    /// When [`Self::check`] refuses the plan. That is meant for compile time; at run time use [`Self::check`].
    pub const fn assert_schedulable(&self) {
        let Some(refusal) = &self.refusal else {
            return;
        };
        let message = if refusal.is_about_time() {
            self.remedies.add_to(refusal.text().str("; "))
        } else {
            refusal.text()
        };
        panic!("{}", message.as_str());
    }

    /// What would help a refused plan.
    #[must_use]
    pub const fn remedies(&self) -> Remedies {
        self.remedies
    }

    /// Worst-case end of the last of the first set-points, which together take `up_to_bits`, from the start of their cycle. Without
    /// bound in a plan that was refused before responses were worked out.
    #[must_use]
    pub const fn set_points(&self, up_to_bits: u64) -> Response {
        self.cycle
            .set_point_response(up_to_bits, self.requests_end_bits)
    }

    /// Worst-case end of the last request of a cycle, from the start of that cycle; `None` when nothing is asked.
    #[must_use]
    pub const fn requests(&self) -> Option<Response> {
        if self.cycle.requests == 0 {
            return None;
        }
        Some(self.cycle.request_response(self.requests_end_bits))
    }

    /// Worst-case end of a reply, from the start of the cycle of its request; `None` when nothing is asked.
    #[must_use]
    pub const fn replies(&self) -> Option<Response> {
        if self.cycle.requests == 0 {
            return None;
        }
        Some(self.cycle.reply_response(self.requests_end_bits))
    }

    /// From the earliest to the latest moment in its cycle at which a drive offers a reply, in bit times; 0 when nothing is asked or
    /// the plan was refused before responses were worked out.
    #[must_use]
    pub const fn reply_jitter_bits(&self) -> u32 {
        match self.requests_end_bits {
            Some(end_bits) if self.cycle.requests > 0 => {
                narrow(self.cycle.reply_jitter_bits(end_bits))
            }
            _ => 0,
        }
    }

    /// Worst-case end of an alarm frame, from when the drive offers it; `None` when none are planned. Its deadline is two
    /// cycles, the span in which the burst must be over.
    #[must_use]
    pub const fn alarms(&self) -> Option<Response> {
        if self.cycle.alarms == 0 {
            return None;
        }
        Some(self.cycle.alarm_response(self.requests_end_bits))
    }

    /// Bit times that a full cycle carries at most: set-points, requests and replies up to the budget, alarms, errors.
    #[must_use]
    pub const fn load_bits(&self) -> u64 {
        self.cycle.load_bits(self.cycle.set_points_bits)
    }

    /// Bit times of a cycle.
    #[must_use]
    pub const fn cycle_bits(&self) -> u64 {
        self.cycle.bits
    }

    /// Requests that may go out in one cycle: the budget, or all drives that are asked at all, because each is asked once at most.
    #[must_use]
    pub const fn requests_per_cycle(&self) -> u64 {
        self.cycle.requests
    }

    /// What is worth knowing although it is admitted.
    #[must_use]
    pub const fn warnings(&self) -> [Option<Warning>; 2] {
        self.warnings
    }

    /// The first set-point with which a cycle carries more than it can.
    const fn overload(&self, drives: &[Drive]) -> Option<Refusal> {
        let (mut up_to_bits, mut rest) = (0, drives);
        while let Some((drive, behind)) = rest.split_first() {
            up_to_bits += drive.set_point_bits as u64;
            let load_bits = self.cycle.load_bits(up_to_bits);
            if load_bits > self.cycle.bits {
                return Some(Refusal::Overload {
                    drive: drive.number,
                    load_bits,
                    cycle_bits: self.cycle.bits,
                });
            }
            rest = behind;
        }
        None
    }

    const fn late_frame(&self, drives: &[Drive]) -> Option<Refusal> {
        let (mut up_to_bits, mut rest) = (0, drives);
        while let Some((drive, behind)) = rest.split_first() {
            up_to_bits += drive.set_point_bits as u64;
            let response = self.set_points(up_to_bits);
            if !response.is_met() {
                return Some(Refusal::LateSetPoint {
                    drive: drive.number,
                    response,
                });
            }
            rest = behind;
        }
        match (self.requests(), self.replies(), self.alarms()) {
            (Some(response), _, _) if !response.is_met() => Some(Refusal::LateRequest { response }),
            (_, Some(response), _) if !response.is_met() => Some(Refusal::LateReply { response }),
            (_, _, Some(response)) if !response.is_met() => Some(Refusal::LateAlarm { response }),
            _ => None,
        }
    }
}

const fn warnings(drives: &[Drive], requests: u64) -> [Option<Warning>; 2] {
    let (mut high, mut rest) = (None, drives);
    while let Some((drive, behind)) = rest.split_first() {
        if drive.last_id >= FIRST_HIGH_ID {
            high = Some(Warning::HighIdentifiers {
                drive: drive.number,
            });
        }
        rest = behind;
    }
    let permille = poll_stretch_permille(drives, requests);
    let stretched = if permille > 1_000 {
        Some(Warning::PollsStretched { permille })
    } else {
        None
    };
    [high, stretched]
}

#[cfg(test)]
mod tests;
