//! The campaign with wheels: speeds, positions and torques of hub motors, faults of drives and of the whole bus.

mod observer;
mod run;

use core::fmt;

use can_motion::wheel::{WheelConfig, WheelLimits, WheelMode};
use can_motion::{GroupId, Reaction};
use drive_sim::ReplyDamage;
use zlac8030l::NodeId;

pub use run::{WheelMutation, run};

use super::draw::Draw;
use super::scenario::Command;

/// Nothing moves and nothing is injected behind this part of a run; then everything is disabled.
pub(super) const MOTION_CYCLES: u64 = 1_000;
/// Earliest injection: wheels may still be set up.
const FIRST_CYCLE: u64 = 100;
const TORQUE_SALT: u64 = 0x746F_7271;

/// A fault of drives or of the bus.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    missing_docs,
    reason = "each kind says what happens, and for how many milliseconds"
)]
pub enum WheelTrouble {
    Trip { wheel: usize, bits: u16 },
    EmergencyInput { wheel: usize },
    PowerCycle { wheel: usize, ms: u64 },
    LeaveBus { wheel: usize, ms: u64 },
    FallSilent { wheel: usize, ms: u64 },
    SpoilReply { wheel: usize, damage: ReplyDamage },
    Unplug { ms: u64 },
    Block { ms: u64 },
    Disturb { ms: u64 },
    Corrupt { frames: u32, at_bit: u32 },
    MissCycles { cycles: u64 },
}

impl WheelTrouble {
    /// How long no frame of the master gets through by it.
    fn outage_ms(self) -> u64 {
        match self {
            Self::Unplug { ms } | Self::Block { ms } => ms,
            _ => 0,
        }
    }

    fn draw(draw: &mut Draw, wheels: usize) -> Self {
        let wheel = draw.between(0, wheels as u64 - 1) as usize;
        let ms = if draw.chance(50) {
            draw.between(1, 20)
        } else {
            draw.between(30, 1_200)
        };
        match draw.between(0, 10) {
            0 => Self::Trip {
                wheel,
                bits: draw.pick(&[0x0001, 0x0002, 0x0004, 0x0010, 0x0020]),
            },
            1 => Self::EmergencyInput { wheel },
            2 => Self::PowerCycle { wheel, ms },
            3 => Self::LeaveBus { wheel, ms },
            4 => Self::FallSilent { wheel, ms },
            5 => Self::SpoilReply {
                wheel,
                damage: draw.pick(&[
                    ReplyDamage::Drop,
                    ReplyDamage::Delay(40_000_000),
                    ReplyDamage::Duplicate,
                    ReplyDamage::WrongIndex,
                    ReplyDamage::WrongSub,
                    ReplyDamage::Short,
                ]),
            },
            6 => Self::Unplug { ms },
            7 => Self::Block { ms },
            8 => Self::Disturb { ms: ms.min(20) },
            9 => Self::Corrupt {
                frames: draw.between_u32(1, 10),
                at_bit: draw.between_u32(2, 60),
            },
            _ => Self::MissCycles {
                cycles: draw.between(1, 20),
            },
        }
    }
}

/// One run.
#[derive(Debug, Clone)]
pub struct WheelScenario {
    /// What it was drawn from.
    pub seed: u64,
    /// The wheels; those with an even node are in group 1 when there are two groups.
    pub wheels: Vec<WheelConfig>,
    /// Commands of the application: cycle, group, command.
    pub orders: Vec<(u64, GroupId, Command)>,
    /// Cycle and fault.
    pub troubles: Vec<(u64, WheelTrouble)>,
    /// So many cycles behind a fault its cause is removed and the group cleared.
    pub recover_after: Option<u64>,
}

impl WheelScenario {
    /// The scenario of a seed.
    ///
    /// # Panics
    /// Never: nodes 1 to 4 exist.
    #[must_use]
    pub fn from_seed(seed: u64) -> Self {
        let mut draw = Draw::new(seed);
        let (count, groups) = (draw.between(1, 4) as usize, draw.between(1, 2) as u8);
        let is_velocity = draw.chance(50);
        // Drawn apart, so that other runs stay what they are.
        let is_torque = Draw::new(seed ^ TORQUE_SALT).chance(30);
        let reaction = draw.pick(&[Reaction::Halt, Reaction::RampDown, Reaction::Disable]);
        let wheel = |number: usize| {
            let node = NodeId::new(number as i32).expect("a node");
            let (mode, limits) = if is_torque {
                let mode = WheelMode::Torque { slope_ma_s: 5_000 };
                (mode, WheelLimits::torque(500, 20, 600))
            } else if is_velocity {
                (WheelMode::Velocity, WheelLimits::speed(300, 10))
            } else {
                let mode = WheelMode::Position {
                    profile_speed_rpm: 1_000,
                };
                let limits = WheelLimits::position(-0x3FFF_FFFF, 0x3FFF_FFFF, 400, 20);
                // Two cycles to take a target, and the way to get to speed.
                let following_error = 4_096;
                (
                    mode,
                    WheelLimits {
                        following_error,
                        ..limits
                    },
                )
            };
            let mut wheel = WheelConfig::new(node, mode, limits);
            wheel.group = GroupId(((number + 1) % usize::from(groups)) as u8);
            wheel.reactions.drive = reaction;
            wheel
        };
        let wheels: Vec<_> = (1..=count).map(wheel).collect();
        let when = |draw: &mut Draw| draw.between(FIRST_CYCLE, MOTION_CYCLES - 200);
        let count_of = |draw: &mut Draw, percent, most| {
            let some = draw.chance(percent);
            if some { draw.between(1, most) } else { 0 }
        };
        let orders = count_of(&mut draw, 50, 3);
        let mut orders: Vec<_> = (0..orders)
            .map(|_| {
                let command = draw.pick(&[Command::Stop, Command::Halt, Command::Disable]);
                let group = GroupId(draw.between(0, u64::from(groups) - 1) as u8);
                (when(&mut draw), group, command)
            })
            .collect();
        orders.sort_by_key(|(cycle, ..)| *cycle);
        let troubles = count_of(&mut draw, 80, 4);
        let mut troubles: Vec<_> = (0..troubles)
            .map(|_| (when(&mut draw), WheelTrouble::draw(&mut draw, count)))
            .collect();
        troubles.sort_by_key(|(cycle, _)| *cycle);
        Self {
            seed,
            wheels,
            orders,
            troubles,
            recover_after: draw.chance(75).then(|| draw.between(1, 300)),
        }
    }
}

impl fmt::Display for WheelScenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mode = self.wheels.first().map(|wheel| wheel.mode);
        writeln!(
            f,
            "seed {}: {} wheels, {mode:?}, clear after {:?} cycles",
            self.seed,
            self.wheels.len(),
            self.recover_after
        )?;
        for (cycle, GroupId(group), command) in &self.orders {
            writeln!(f, "  cycle {cycle}: {command:?} group {group}")?;
        }
        for (cycle, trouble) in &self.troubles {
            writeln!(f, "  cycle {cycle}: {trouble:?}")?;
        }
        Ok(())
    }
}
