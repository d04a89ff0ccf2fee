//! What one run of the campaign does, as data that prints as text.

use core::fmt;

use can_motion::{AxisConfig, GroupId, MasterConfig};
use drive_sim::{ResponseDelay, TxOrder};
use dyn_can::{ParamGroup2, Revision};

use super::injection::Injection;
use super::path::Path;

/// Room of the master for axes.
pub(super) const MOST_AXES: usize = 8;

/// Moves of one group in mid-motion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MoveOrder {
    /// When, in microseconds.
    pub at_us: u64,
    /// Of whom.
    pub group: GroupId,
    /// Loaded, and started by the trigger for all at once.
    pub by_trigger: bool,
    /// Told as distances, and not as places.
    pub is_relative: bool,
    /// How far each axis of the scenario goes.
    pub distances_counts: Vec<i32>,
    /// The application stops them so long after their start.
    pub stop_after_us: Option<u64>,
}

/// One axis: its drive, its settings in the master, and its motion.
#[derive(Debug, Clone)]
pub struct AxisPlan {
    /// Settings in the master.
    pub config: AxisConfig,
    /// Revision of the drive.
    pub revision: Revision,
    /// The drive reports quarters of a command count.
    pub fine_read_back: bool,
    /// Where the shaft is at first, in command counts.
    pub start_counts: i64,
    /// Time from a request to its reply.
    pub response_delay: ResponseDelay,
    /// Seed of that time.
    pub delay_seed: u64,
    /// The curve that its drive has for moves of its own; `None` in a run without moves.
    pub curve: Option<ParamGroup2>,
    /// Motion, as offsets from where the axis was when it began to stream.
    pub path: Path,
}

/// When the software of the master looks at its controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServiceTiming {
    /// After each frame, as from interrupts.
    EachFrame,
    /// With this period, as from a timer.
    EveryUs(u64),
}

/// What the application wants of a group in mid-motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// `Master::stop`.
    Stop,
    /// `Master::halt`.
    Halt,
    /// `Master::disable`.
    Disable,
}

/// A command at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Order {
    /// When, in microseconds.
    pub at_us: u64,
    /// To whom.
    pub group: GroupId,
    /// What.
    pub command: Command,
    /// How long the group then rests before the application lets it go on.
    pub rest_us: u64,
}

/// One run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// The seed from which everything was drawn.
    pub seed: u64,
    /// Length in virtual time.
    pub duration_us: u64,
    /// From then on nothing moves, nothing is injected and nothing is recovered.
    pub calm_from_us: u64,
    /// Order of the master's mailboxes.
    pub tx_order: TxOrder,
    /// When the master is served.
    pub service: ServiceTiming,
    /// Settings of the master.
    pub master: MasterConfig,
    /// Axes, in ascending order of drive id.
    pub axes: Vec<AxisPlan>,
    /// Groups are numbered from 0.
    pub groups: u8,
    /// Commands in mid-motion, by time.
    pub orders: Vec<Order>,
    /// Moves that drives make by themselves, by time.
    pub moves: Vec<MoveOrder>,
    /// Time from a fault to the application's `clear`; `None` when it never clears.
    pub recover_after_us: Option<u64>,
    /// Faults, by time.
    pub injections: Vec<Injection>,
}

impl Scenario {
    /// Groups of this scenario.
    pub fn group_ids(&self) -> impl Iterator<Item = GroupId> + use<> {
        (0..self.groups).map(GroupId)
    }
}

impl fmt::Display for Scenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "seed {}: {} axes in {} groups, {} ms, calm from {} ms, mailboxes {:?}, service {:?}, replies within {} us, {} requests a cycle, clear after {:?} us",
            self.seed,
            self.axes.len(),
            self.groups,
            self.duration_us / 1_000,
            self.calm_from_us / 1_000,
            self.tx_order,
            self.service,
            self.master.timeouts.reply_us,
            self.master.requests_per_cycle,
            self.recover_after_us,
        )?;
        for (index, axis) in self.axes.iter().enumerate() {
            write_axis(f, index, axis)?;
        }
        for order in &self.orders {
            writeln!(
                f,
                "  {} us: {:?} group {}, rest {} us",
                order.at_us, order.command, order.group.0, order.rest_us
            )?;
        }
        for order in &self.moves {
            writeln!(f, "  {order:?}")?;
        }
        for injection in &self.injections {
            writeln!(f, "  {injection}")?;
        }
        Ok(())
    }
}

fn write_axis(f: &mut fmt::Formatter<'_>, index: usize, axis: &AxisPlan) -> fmt::Result {
    let (config, limits) = (&axis.config, &axis.config.limits);
    let polls = &config.polls;
    writeln!(
        f,
        "  axis {index}: drive {}, group {}, {:?}, start {}, replies {}..={} us, step <= {}, change {}/256, backlog {}, following {}, drift {}, fine read-back {}, polls {:?}/{:?}/{:?}/{:?}/{:?}, {:?}, curve {:?}",
        config.drive,
        config.group.0,
        axis.revision,
        axis.start_counts,
        axis.response_delay.min_ns() / 1_000,
        axis.response_delay.max_ns() / 1_000,
        limits.max_step.get(),
        limits.max_step_change.per_256_cycles(),
        limits.backlog_counts,
        limits.following_error_counts,
        limits.drift_tolerance_counts,
        axis.fine_read_back,
        polls.status_us,
        polls.position_us,
        polls.torque_us,
        polls.speed_us,
        polls.counter_us,
        config.reactions,
        axis.curve,
    )
}
