//! Wheels in velocity mode.

use can_motion::facts::{Facts, Motion};
use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelEventKind, WheelFault, WheelLimits, WheelMasterConfig,
    WheelMode, WheelReactions, WheelSnapshot, WheelTimeouts, Zlac,
};
use can_motion::{Confirmation, GroupId, Master, Reaction, Reason};
use dyn_can::DataFrame;
use fastrand::Rng;
use zlac8030l::{NodeId, SdoRequest, SdoTimeouts, objects};

use super::subject::{
    AXES, Answer, Asked, AxisRules, Command, GROUP_OF, Rules, Seen, Subject, Told,
};
use super::wheel_drive::{PRE_OPERATIONAL, WheelDrive};

/// Feedback comes so often.
const FEEDBACK_US: u64 = 10_000;

/// Nodes 1, 2 and 3.
#[derive(Debug)]
pub struct Wheels {
    config: WheelMasterConfig,
    axes: Vec<WheelConfig>,
    drives: Vec<WheelDrive>,
}

impl Subject for Wheels {
    type Family = Zlac;

    fn draw(random: &mut Rng) -> Self {
        let config = WheelMasterConfig {
            requests_per_cycle: random.u8(1..=3),
            feedback: FeedbackTiming::Timer { ticks: 20 },
            timeouts: WheelTimeouts {
                power_on_us: 20_000,
                sdo: SdoTimeouts {
                    reply_us: 25_000,
                    settle_us: 1_000,
                },
                heartbeat_ms: 50,
                heartbeat_lost_us: 200_000,
                standstill_us: 30_000,
                standstill_limit_us: 500_000,
                confirm_us: 100_000,
                ..WheelTimeouts::DEFAULT
            },
            ..WheelMasterConfig::DEFAULT
        };
        let axes = (1..).zip(GROUP_OF).take(AXES).map(|(node, group)| {
            let node = NodeId::new(node).expect("a node");
            let max = random.u16(20..=800);
            let limits = WheelLimits::speed(max, random.u32(1..=200));
            let mut axis = WheelConfig::new(node, WheelMode::Velocity, limits);
            axis.group = GroupId(group);
            axis.reactions = WheelReactions {
                drive: if random.bool() {
                    Reaction::Disable
                } else {
                    Reaction::Halt
                },
                ..WheelReactions::DEFAULT
            };
            axis
        });
        let axes = axes.collect();
        let drives = (1..=AXES as u16).map(WheelDrive::new).collect();
        Self {
            config,
            axes,
            drives,
        }
    }

    fn master(&self) -> Master<AXES, Zlac> {
        Master::new(self.config, &self.axes).expect("a configuration that works")
    }

    fn rules(&self) -> Rules {
        let axes = |axis: usize| {
            let values = self.axes[axis].limits.values;
            AxisRules {
                min: values.min,
                max: values.max,
                max_step: values.max_step as i32,
                ramp_cycles: values.max / values.max_step as i32 + 1,
            }
        };
        let timeouts = &self.config.timeouts;
        let cycle_us = u64::from(self.config.cycle_us);
        Rules {
            cycle_us,
            stuck_us: u64::from(timeouts.stuck_us).max(5 * cycle_us),
            confirm_us: u64::from(timeouts.confirm_us),
            reply_us: u64::MAX / 2,
            standstill_us: u64::from(timeouts.standstill_us),
            requests_per_cycle: i32::from(self.config.requests_per_cycle),
            groups: GROUP_OF,
            axes: [axes(0), axes(1), axes(2)],
            asks_one_at_a_time: false,
            is_asked: false,
            is_absolute: true,
            has_cycle_frames: true,
            anchors_after_enable: false,
            is_speed: true,
            alarm_frees_shaft: false,
        }
    }

    fn axis_of(frame: &DataFrame) -> Option<usize> {
        let node = match (frame.id(), frame.data()) {
            (0, [_, node]) => usize::from(*node),
            (id, _) => usize::from(id & 0x7F),
        };
        node.checked_sub(1).filter(|axis| *axis < AXES)
    }

    fn command(&self, frame: &DataFrame) -> Command {
        match (frame.id() & 0x780, frame.data()) {
            (0x000, [_, _]) => Command::Change,
            (0x300, &[low, _, a, b, c, d]) => match (low, i32::from_le_bytes([a, b, c, d])) {
                (0x00, _) => Command::OffInCycle,
                (0x02, _) => Command::Brake,
                (0x0F, 0) => Command::Hold,
                (0x0F, value) => Command::Target(value),
                _ => Command::On,
            },
            (0x600, [0x40 | 0x80, ..]) => Command::Ask,
            (0x600, [_, 0x40, 0x60, 0, 0, 0, ..]) => Command::Off,
            (0x600, [_, 0x40, 0x60, 0, 2, 0, ..]) => Command::BrakeAsked,
            (0x600, _) => Command::Change,
            _ => Command::Nothing,
        }
    }

    fn told(&self, frame: &DataFrame) -> Told {
        let power_of = |status: u16| match status & 0xF {
            0x7 => Some(true),
            0x0 | 0x1 | 0x3 => Some(false),
            other => (other & 8 != 0).then_some(false),
        };
        match (frame.id() & 0x780, frame.data()) {
            (0x180, &[low, high, _, _, a, b, c, d]) => Told {
                power: power_of(u16::from_le_bytes([low, high])),
                stands: Some(i32::from_le_bytes([a, b, c, d]).abs() <= 10),
                ..Told::default()
            },
            (0x580, &[_, 0x41, 0x60, 0, low, high, _, _]) => Told {
                power: power_of(u16::from_le_bytes([low, high])),
                ..Told::default()
            },
            (0x080, [low, high, ..]) => Told {
                is_alarm: (*low, *high) != (0, 0),
                ..Told::default()
            },
            (0x700, [0]) => Told {
                is_boot_up: true,
                ..Told::default()
            },
            _ => Told::default(),
        }
    }

    fn take(
        &mut self,
        now_us: u64,
        frame: &DataFrame,
        asked: Asked,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    ) {
        let Some(drive) = Self::axis_of(frame).and_then(|axis| self.drives.get_mut(axis)) else {
            return;
        };
        if now_us < drive.silent_until_us {
            return;
        }
        let frame = match (frame.id() & 0x780, frame.data()) {
            (0x000, [command, _]) => Some(drive.manage(*command)),
            (0x300, data) => {
                drive.command(data);
                None
            }
            (0x600, data) => drive.transfer(data),
            _ => None,
        };
        let is_lost = random.u16(..3_000) == 0;
        let due_us = now_us + random.u64(100..4_000);
        let frame = frame.filter(|_| !is_lost);
        answers.extend(frame.map(|frame| Answer {
            due_us,
            frame,
            asked: Some(asked),
        }));
    }

    fn pass(&mut self, now_us: u64, _: &mut Rng, answers: &mut Vec<Answer>) {
        for drive in &mut self.drives {
            if now_us < drive.silent_until_us {
                continue;
            }
            let mut says = |frame| {
                let asked = Asked {
                    taken_us: now_us,
                    is_behind_switches: true,
                };
                answers.push(Answer {
                    due_us: now_us,
                    frame,
                    asked: Some(asked),
                });
            };
            let heartbeat_us = drive.heartbeat_us();
            if heartbeat_us != 0 && now_us >= drive.beat_us + heartbeat_us {
                drive.beat_us = now_us;
                says(drive.heartbeat(drive.nmt));
            }
            if now_us >= drive.feedback_us + FEEDBACK_US - FEEDBACK_US / 10 {
                drive.feedback_us = now_us;
                drive.feedback().into_iter().for_each(says);
            }
        }
    }

    fn disturb(
        &mut self,
        axis: usize,
        now_us: u64,
        random: &mut Rng,
        answers: &mut Vec<Answer>,
    ) -> &'static str {
        let drive = &mut self.drives[axis];
        let mut says = |frame| {
            answers.push(Answer {
                due_us: now_us,
                frame,
                asked: None,
            });
        };
        match random.u8(..6) {
            0 => {
                *drive = WheelDrive::new(drive.node);
                says(drive.heartbeat(0));
                "reboots"
            }
            1 => {
                says(drive.trip(1 << random.u8(1..8)));
                "trips"
            }
            2 => {
                drive.silent_until_us = now_us + random.u64(5_000..600_000);
                "falls silent"
            }
            3 => {
                drive.state = if drive.fault == 0 { 7 } else { 0 };
                "is switched on by somebody else"
            }
            4 => {
                drive.nmt = PRE_OPERATIONAL;
                "leaves operation"
            }
            _ => {
                drive.state = 0;
                drive.speed_decirpm = 0;
                "is switched off by somebody else"
            }
        }
    }

    fn seen(&self, axis: usize, kind: &WheelEventKind) -> Seen {
        match kind {
            WheelEventKind::Fault(fault) => {
                let reaction = self.axes[axis].reactions.to(*fault);
                Seen::Fault {
                    is_own: *fault != WheelFault::Group,
                    is_bus: matches!(
                        fault,
                        WheelFault::Bus
                            | WheelFault::Lost
                            | WheelFault::Drive(_)
                            | WheelFault::Emergency(_)
                            | WheelFault::NotOperational(_)
                            | WheelFault::Reboot
                    ),
                    ramps: reaction == Reaction::RampDown,
                    ramps_itself: false,
                    disables: reaction == Reaction::Disable,
                }
            }
            WheelEventKind::State { from, to, reason } => Seen::State {
                from: *from,
                to: *to,
                by_fault: *reason == Reason::Fault,
                is_back: false,
            },
            _ => Seen::Other,
        }
    }

    fn procedure(random: &mut Rng) -> Option<(SdoRequest, Confirmation)> {
        let request = match random.u8(..3) {
            0 => objects::DRIVER_TEMPERATURE.read(),
            1 => objects::MOTOR_TEMPERATURE.read(),
            _ => objects::MAX_SPEED_RPM.write(500),
        };
        Some((request, Confirmation::None))
    }

    fn sent(snapshot: &WheelSnapshot) -> i32 {
        snapshot.sent
    }

    /// At rest the frames of a cycle carry no target.
    fn compares(facts: &Facts) -> bool {
        facts.motion != Motion::Rest
    }

    fn undisturbed_position(&self, _: usize) -> Option<i64> {
        None
    }

    fn anchored(&mut self, _: usize) {}
}
