//! Whether a bus carries its axes: [`BusPlan`].

use dyn_can::DriveId;

use super::analysis::Response;
use super::burst::Burst;
use super::cycle::{Cycle, RequestPlace, narrow};
use super::demand::{cycle_of, poll_stretch_permille};
use super::frames::{set_point_bits, usual_set_point_bits};
use super::refusal::{Refusal, Warning};
use super::remedies::Remedies;
use super::setup::TxOrder;
use crate::servo::config::{AxisConfig, MasterConfig};

/// The worst case of a bus, and whether it is good enough.
///
/// [`Master::new`](crate::Master::new) asks it and takes no axes that it refuses. Evaluate it in a `const` as well: then a set of
/// axes that cannot be scheduled does not compile, and the message names the frame that is late. Hand that constant to
/// [`Master::with_plan`](crate::Master::with_plan), and nothing of the analysis is left in the program.
///
/// ```
/// use can_motion::plan::BusPlan;
/// use can_motion::{AxisConfig, Limits, MasterConfig, MotorLimits, Travel};
/// use dyn_can::{DriveId, GearNumber};
///
/// const GEAR: GearNumber = match GearNumber::new(4_096) {
///     Ok(gear) => gear,
///     Err(_) => panic!("gear numbers are 500..=16384"),
/// };
/// const MOTOR: MotorLimits = MotorLimits { speed_rpm: 3_000, acceleration_rpm_per_s: 3_000 };
/// const LIMITS: Limits = match Limits::of_motor(MOTOR, Travel::WHOLE, GEAR, 1_000) {
///     Ok(limits) => limits,
///     Err(_) => panic!("a step of 819 counts fits"),
/// };
///
/// const fn axis(drive: i32) -> AxisConfig {
///     match DriveId::new(drive) {
///         Ok(drive) => AxisConfig::new(drive, GEAR, LIMITS),
///         Err(_) => panic!("drive ids are 1..=63"),
///     }
/// }
///
/// const MASTER: MasterConfig = MasterConfig::DEFAULT;
/// const AXES: [AxisConfig; 3] = [axis(1), axis(2), axis(3)];
/// const _: () = BusPlan::new(&MASTER, &AXES).assert_schedulable();
/// ```
///
/// Eleven axes more, and it no longer compiles:
///
/// ```compile_fail,E0080
/// # use can_motion::plan::BusPlan;
/// # use can_motion::{AxisConfig, Limits, MasterConfig, MotorLimits, Travel};
/// # use dyn_can::{DriveId, GearNumber};
/// # const GEAR: GearNumber = match GearNumber::new(4_096) {
/// #     Ok(gear) => gear,
/// #     Err(_) => panic!("gear numbers are 500..=16384"),
/// # };
/// # const MOTOR: MotorLimits = MotorLimits { speed_rpm: 3_000, acceleration_rpm_per_s: 3_000 };
/// # const LIMITS: Limits = match Limits::of_motor(MOTOR, Travel::WHOLE, GEAR, 1_000) {
/// #     Ok(limits) => limits,
/// #     Err(_) => panic!("a step of 819 counts fits"),
/// # };
/// # const fn axis(drive: i32) -> AxisConfig {
/// #     match DriveId::new(drive) {
/// #         Ok(drive) => AxisConfig::new(drive, GEAR, LIMITS),
/// #         Err(_) => panic!("drive ids are 1..=63"),
/// #     }
/// # }
/// const AXES: [AxisConfig; 14] = [
///     axis(1), axis(2), axis(3), axis(4), axis(5), axis(6), axis(7), axis(8), axis(9), axis(10), axis(11), axis(12), axis(13),
///     axis(14),
/// ];
/// const _: () = BusPlan::new(&MasterConfig::DEFAULT, &AXES).assert_schedulable();
/// ```
#[derive(Debug, Clone, Copy)]
pub struct BusPlan<'a> {
    config: MasterConfig,
    axes: &'a [AxisConfig],
    cycle: Cycle,
    /// Kept, so that a plan made in a `const` needs no table at run time.
    burst: Burst,
    /// When the last request of a cycle is through.
    requests_end_bits: Option<u64>,
    poll_stretch_permille: u32,
    pub(super) refusal: Option<Refusal>,
    remedies: Remedies,
}

impl<'a> BusPlan<'a> {
    /// The same plan with advice.
    pub(super) const fn with(self, remedies: Remedies) -> Self {
        Self { remedies, ..self }
    }

    /// The plan with or without polls, and no advice.
    pub(super) const fn of(
        config: &MasterConfig,
        axes: &'a [AxisConfig],
        is_polled: bool,
        place: RequestPlace,
    ) -> Self {
        let cycle = cycle_of(config, axes, is_polled, place);
        let mut plan = Self {
            config: *config,
            axes,
            cycle,
            burst: usual_burst(config, axes, &cycle),
            requests_end_bits: None,
            poll_stretch_permille: poll_stretch_permille(config, axes, cycle.requests),
            refusal: Refusal::outright(&config.bus, axes),
            remedies: Remedies::NONE,
        };
        if plan.refusal.is_none() {
            plan.refusal = plan.overload();
        }
        if plan.refusal.is_none() {
            plan.requests_end_bits = cycle.requests_end_bits();
            plan.refusal = plan.late_frame();
        }
        plan
    }

    /// Whether the master may choose the place of the requests among the set-points. A controller that sorts by identifier would
    /// give them back when set-points come behind them.
    pub(crate) const fn has_room_for_requests(&self) -> bool {
        matches!(
            (self.cycle.order, self.cycle.place),
            (TxOrder::Fifo, RequestPlace::Anywhere)
        ) && self.cycle.requests > 0
    }

    /// The usual times on the wire.
    pub(crate) const fn burst(&self) -> Burst {
        self.burst
    }

    /// The settings of the master that it was made for.
    #[must_use]
    pub const fn config(&self) -> &MasterConfig {
        &self.config
    }

    /// The axes that it was made for.
    #[must_use]
    pub const fn axes(&self) -> &'a [AxisConfig] {
        self.axes
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

    /// Worst-case end of the set-point of an axis from the start of its cycle; `None` when there is no such axis. Without bound
    /// in a plan that was refused before responses were worked out.
    #[must_use]
    pub const fn set_point(&self, axis: usize) -> Option<Response> {
        let (mut up_to_bits, mut index, mut rest) = (0, 0, self.axes);
        while let Some((each, behind)) = rest.split_first() {
            up_to_bits += set_point_bits(each) as u64;
            if index == axis {
                return Some(
                    self.cycle
                        .set_point_response(up_to_bits, self.requests_end_bits),
                );
            }
            index += 1;
            rest = behind;
        }
        None
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

    /// Requests that may go out in one cycle: the budget, or all axes that are asked at all, because each is asked once at most.
    #[must_use]
    pub const fn requests_per_cycle(&self) -> u64 {
        self.cycle.requests
    }

    /// What is worth knowing although it is admitted.
    #[must_use]
    pub const fn warnings(&self) -> [Option<Warning>; 2] {
        let mut drive_63 = None;
        let mut rest = self.axes;
        while let Some((axis, behind)) = rest.split_first() {
            if axis.drive.get() == DriveId::MAX.get() {
                drive_63 = Some(Warning::Drive63);
            }
            rest = behind;
        }
        let permille = self.poll_stretch_permille;
        let stretched = if permille > 1_000 {
            Some(Warning::PollsStretched { permille })
        } else {
            None
        };
        [drive_63, stretched]
    }

    /// The first set-point with which a cycle carries more than it can.
    const fn overload(&self) -> Option<Refusal> {
        let (mut up_to_bits, mut rest) = (0, self.axes);
        while let Some((axis, behind)) = rest.split_first() {
            up_to_bits += set_point_bits(axis) as u64;
            let load_bits = self.cycle.load_bits(up_to_bits);
            if load_bits > self.cycle.bits {
                return Some(Refusal::Overload {
                    drive: axis.drive,
                    load_bits,
                    cycle_bits: self.cycle.bits,
                });
            }
            rest = behind;
        }
        None
    }

    const fn late_frame(&self) -> Option<Refusal> {
        let (mut up_to_bits, mut rest) = (0, self.axes);
        while let Some((axis, behind)) = rest.split_first() {
            up_to_bits += set_point_bits(axis) as u64;
            let response = self
                .cycle
                .set_point_response(up_to_bits, self.requests_end_bits);
            if !response.is_met() {
                return Some(Refusal::LateSetPoint {
                    drive: axis.drive,
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

const fn usual_burst(config: &MasterConfig, axes: &[AxisConfig], cycle: &Cycle) -> Burst {
    let rate = config.bus.bit_rate;
    Burst {
        set_point_us: rate.us_covering(usual_set_point_bits(axes)),
        request_us: rate.us_covering(narrow(cycle.request_bits)),
        reply_us: rate.us_covering(narrow(cycle.reply_bits)),
        requests: narrow(cycle.requests),
    }
}

#[cfg(test)]
mod tests;
