//! Whether a bus carries its servo axes: the frames of each axis, and the [`CyclePlan`] of them.

use bus_plan::analysis::Response;
use bus_plan::{Clash, CyclePlan, CycleSetup, Drive, Refusal, Remedies, Requests};
use can_frame::wire::bound_bits;
use dyn_can::{Address, DriveId, FunctionCode};

use crate::servo::bus_frames::{alarm_bits, poll_bits, reply_bits, set_point_bits};
use crate::servo::config::{AxisConfig, MasterConfig};
use crate::servo::poll_kind::PollKind;

/// Longest request of the protocol in bytes: Set_Param_Group3.
const LONGEST_REQUEST: u8 = 5;

/// Longest reply of the protocol in bytes: Read_Param_Group3 of revision 1.6A.
const LONGEST_REPLY: u8 = 6;

/// Shortest frame of the protocol, without stuff bits: no data.
const SHORTEST_BITS: u16 = 47;

/// One more than there are drive ids: a longer list has one twice, and the plan sees which.
const MOST_AXES: usize = 64;

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
    cycle: CyclePlan,
}

impl<'a> BusPlan<'a> {
    /// Works out the worst case of these axes, in the order in which the master sends their set-points.
    ///
    /// Takes no notice of what [`Master::new`](crate::Master::new) checks and the bus does not care about.
    #[must_use]
    pub const fn new(config: &MasterConfig, axes: &'a [AxisConfig]) -> Self {
        let setup = CycleSetup {
            bus: config.bus,
            cycle_us: config.cycle_us,
            requests_per_cycle: config.requests_per_cycle,
            reply_us: config.timeouts.reply_us,
            any_request: Requests::any(
                SHORTEST_BITS,
                bound_bits(LONGEST_REQUEST),
                bound_bits(LONGEST_REPLY),
            ),
            bit_rates: &dyn_can::BIT_RATES,
            clash: clash(config, axes),
        };
        let mut drives = [Drive::silent(0, 0); MOST_AXES];
        let (mut count, mut rest) = (0, axes);
        while let (Some((_, [drive, ..])), Some((axis, behind))) =
            (drives.split_at_mut_checked(count), rest.split_first())
        {
            *drive = frames_of(axis, config.cycle_us);
            (count, rest) = (count + 1, behind);
        }
        let planned = match drives.split_at_checked(count) {
            Some((planned, _)) => planned,
            None => &drives,
        };
        Self {
            config: *config,
            axes,
            cycle: CyclePlan::new(&setup, planned),
        }
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

    /// The verdict on the frames of a cycle, with every bound but those of the set-points.
    #[must_use]
    pub const fn cycle(&self) -> &CyclePlan {
        &self.cycle
    }

    /// Whether every frame is in time.
    ///
    /// # Errors
    /// [`Refusal`] with the first frame that is not, or with what cannot be on one bus at all.
    pub const fn check(&self) -> Result<(), Refusal> {
        self.cycle.check()
    }

    /// Makes a `const` that is not schedulable fail to compile, with the frame, its response, its deadline and what would help in the
    /// message.
    ///
    /// # Panics
    /// When [`Self::check`] refuses the plan. That is meant for compile time; at run time use [`Self::check`].
    pub const fn assert_schedulable(&self) {
        self.cycle.assert_schedulable();
    }

    /// What would help a refused plan.
    #[must_use]
    pub const fn remedies(&self) -> Remedies {
        self.cycle.remedies()
    }

    /// Worst-case end of the set-point of an axis from the start of its cycle; `None` when there is no such axis. Without bound
    /// in a plan that was refused before responses were worked out.
    #[must_use]
    pub fn set_point(&self, axis: usize) -> Option<Response> {
        let up_to = self.axes.get(..=axis)?;
        let bits = up_to
            .iter()
            .map(|axis| u64::from(set_point_bits(axis)))
            .sum();
        Some(self.cycle.set_points(bits))
    }
}

/// The frames of an axis.
const fn frames_of(axis: &AxisConfig, cycle_us: u32) -> Drive {
    let (mut polls, mut kinds): (_, &[PollKind]) = (Requests::NONE, &PollKind::ALL);
    while let Some((kind, others)) = kinds.split_first() {
        if let Some(period_us) = axis.polls.of(*kind) {
            let (request, reply) = (poll_bits(axis, *kind), reply_bits(axis.drive, *kind));
            polls = polls.and(period_us, cycle_us, request, reply);
        }
        kinds = others;
    }
    Drive {
        number: axis.drive.get(),
        group: axis.group.0,
        last_id: axis.drive.can_id(FunctionCode::DiagnosticCounter),
        set_point_bits: set_point_bits(axis),
        polls,
        alarm_bits: alarm_bits(axis),
    }
}

/// The first identifier of CANopen that one of these axes, or every drive, would take for its own (D9).
const fn clash(config: &MasterConfig, axes: &[AxisConfig]) -> Option<Clash> {
    let Some(canopen) = &config.bus.canopen else {
        return None;
    };
    let mut place = 0;
    while let Some(identifier) = canopen.identifier(place) {
        let drive = Address::from_can_id(identifier.id).drive();
        if concerns(drive, axes) {
            return Some(Clash {
                canopen: identifier,
                drive: match drive {
                    Some(drive) => Some(drive.get()),
                    None => None,
                },
                meaning: name_of(FunctionCode::from_can_id(identifier.id)),
            });
        }
        place += 1;
    }
    None
}

/// Without the feature `names` an image has none of them: the identifier tells the function.
const fn name_of(function: FunctionCode) -> &'static str {
    if cfg!(feature = "names") {
        function.name()
    } else {
        "a function"
    }
}

const fn concerns(drive: Option<DriveId>, axes: &[AxisConfig]) -> bool {
    let Some(drive) = drive else {
        return true;
    };
    let mut rest = axes;
    while let Some((axis, behind)) = rest.split_first() {
        if axis.drive.get() == drive.get() {
            return true;
        }
        rest = behind;
    }
    false
}

#[cfg(test)]
mod tests;
