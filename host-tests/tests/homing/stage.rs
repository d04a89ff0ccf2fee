//! One drive with its mechanics, the master, and a homing.

use can_motion::{AxisConfig, Limits, MasterConfig, PollPeriods, StepChange, Travel};
use drive_sim::{DynDriveConfig, EndStops, Mechanics, Switch as SimSwitch, SwitchSide, TxOrder};
use dyn_can::{DriveId, GearNumber, Revision, StepLimit};
use homing::{
    Config, Direction, HardStop, Home, Homing, Inputs, Level, Method, Progress, Reading, Switch,
    Watch,
};
use host_tests::rig::Rig;

/// 1 kHz.
const CYCLE_US: u32 = 1_000;

/// Everything random of a test.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Machine {
    pub(crate) revision: Revision,
    pub(crate) direction: Direction,
    /// What the drive reports at power-on.
    pub(crate) start_counts: i32,
    /// From there to the stop or the switch, in the direction of the search; below 0 for a switch that is operated at the start.
    pub(crate) distance: i32,
    /// A switch that is low while it is operated.
    pub(crate) is_low_active: bool,
}

impl Machine {
    pub(crate) const PLAIN: Self = Self {
        revision: Revision::V1_6A,
        direction: Direction::Positive,
        start_counts: 0,
        distance: 5_000,
        is_low_active: false,
    };

    fn place(&self) -> i64 {
        i64::from(self.direction.sign()) * i64::from(self.distance)
    }

    /// The place of stop or switch as the drive reports it.
    pub(crate) fn expected_counts(&self) -> i32 {
        self.start_counts + self.direction.sign() * self.distance
    }

    pub(crate) fn stops(&self) -> EndStops {
        const FAR: i64 = 1 << 40;
        match self.direction {
            Direction::Positive => EndStops {
                low_counts: -FAR,
                high_counts: self.place(),
            },
            Direction::Negative => EndStops {
                low_counts: self.place(),
                high_counts: FAR,
            },
        }
    }

    fn switch(&self) -> SimSwitch {
        SimSwitch {
            at_counts: self.place(),
            side: match self.direction {
                Direction::Positive => SwitchSide::Above,
                Direction::Negative => SwitchSide::Below,
            },
        }
    }

    pub(crate) fn hard_stop(&self) -> Config {
        config(Method::HardStop(HardStop {
            direction: self.direction,
            contact_permille: 200,
            most_permille: 600,
            contact_counts: 90,
            most_counts: 2_000,
            repeat_counts: 10,
        }))
    }

    pub(crate) fn limit_switch(&self) -> Config {
        config(Method::Switch(Switch {
            direction: self.direction,
            operated: if self.is_low_active {
                Level::Low
            } else {
                Level::High
            },
            most_counts: 1_000,
            most_permille: None,
        }))
    }
}

/// 8 counts a cycle are 29 r/min, 2 are 7.
fn config(method: Method) -> Config {
    Config {
        method,
        cycle_us: CYCLE_US,
        search: trajectory::Limits::new(8.0, 0.5, 0.05).unwrap(),
        slow: trajectory::Limits::new(2.0, 0.5, 0.05).unwrap(),
        way_counts: 20_000,
        back_off_counts: 400,
        reference_counts: -50,
        travel: homing::Travel {
            min_counts: -60_000,
            max_counts: 60_000,
        },
        watch: Watch {
            max_age_us: 50_000,
            ..Watch::DEFAULT
        },
    }
}

/// A drive that streams, and what its homing has done to it.
pub(crate) struct Stage {
    pub(crate) rig: Rig,
    pub(crate) machine: Machine,
    /// Farthest set-point and shaft position in the direction of the search, in counts of the drive.
    pub(crate) farthest_sent: i32,
    /// What the application tells the homing instead of the truth.
    pub(crate) lie: Box<dyn Fn(&mut Inputs)>,
    pub(crate) cycles: u32,
}

impl Stage {
    pub(crate) fn new(machine: Machine) -> Self {
        Self::with(machine, Mechanics::FREE)
    }

    pub(crate) fn with_stop(machine: Machine) -> Self {
        let mechanics = Mechanics {
            stops: Some(machine.stops()),
            ..Mechanics::FREE
        };
        Self::with(machine, mechanics)
    }

    pub(crate) fn with_switch(machine: Machine) -> Self {
        let mechanics = Mechanics {
            switch: Some(machine.switch()),
            ..Mechanics::FREE
        };
        Self::with(machine, mechanics)
    }

    pub(crate) fn with(machine: Machine, mechanics: Mechanics) -> Self {
        let drive = DriveId::MIN;
        let limits = Limits {
            // The homing notices first.
            following_error_counts: 8_000,
            drift_tolerance_counts: 4_000,
            ..Limits::new(
                StepLimit::new(20).unwrap(),
                StepChange::from_counts(1).unwrap(),
                Travel::WHOLE,
            )
        };
        let axis = AxisConfig {
            polls: PollPeriods {
                position_us: Some(10_000),
                torque_us: Some(10_000),
                ..PollPeriods::DEFAULT
            },
            ..AxisConfig::new(drive, GearNumber::new(4_096).unwrap(), limits)
        };
        let config = DynDriveConfig {
            start_position_counts: machine.start_counts.into(),
            mechanics,
            ..DynDriveConfig::new(drive).with_revision(machine.revision)
        };
        let mut rig = Rig::new(MasterConfig::DEFAULT, &[axis], vec![config], TxOrder::Fifo);
        rig.stream();
        Self {
            rig,
            machine,
            farthest_sent: machine.start_counts,
            lie: Box::new(|_| {}),
            cycles: 0,
        }
    }

    pub(crate) fn inputs(&self) -> Inputs {
        let axis = self.rig.axis(0);
        let read = axis.feedback;
        let now_ns = self.rig.bench.now_ns();
        let is_operated = self.rig.drive(0).switch_is_operated(now_ns);
        let mut inputs = Inputs {
            sent_counts: axis.sent_counts,
            position: read.position.map(|position| Reading {
                value: position.value,
                at_us: position.at.as_us(),
            }),
            torque_permille: read.torque.map(|torque| Reading {
                value: (torque.value.of_peak() * 1_000.0).round() as i16,
                at_us: torque.at.as_us(),
            }),
            switch: Some(Reading {
                value: is_operated != self.machine.is_low_active,
                at_us: now_ns / 1_000,
            }),
        };
        (self.lie)(&mut inputs);
        inputs
    }

    /// One cycle of homing, master and bus.
    pub(crate) fn cycle(&mut self, homing: &mut Homing) -> Progress {
        let now_us = self.rig.now().as_us();
        let progress = homing.cycle(now_us, &self.inputs());
        if let Progress::Target(target) = progress {
            self.rig
                .master
                .set_target(0, target)
                .unwrap_or_else(|error| panic!("{error}: {:?}", self.rig.axis(0).fault));
        }
        self.rig.cycle();
        self.cycles += 1;
        let sign = self.machine.direction.sign();
        let sent = self.rig.axis(0).sent_counts;
        if sign * (sent - self.farthest_sent) > 0 {
            self.farthest_sent = sent;
        }
        progress
    }

    pub(crate) fn homing(&self, config: Config) -> Homing {
        Homing::new(config, self.rig.axis(0).sent_counts).expect("a configuration that works")
    }

    /// To the end; `meanwhile` is called before every cycle with its number.
    pub(crate) fn run(
        &mut self,
        config: Config,
        mut meanwhile: impl FnMut(&mut Self, &mut Homing, u32),
    ) -> Progress {
        let mut homing = self.homing(config);
        for cycle in 0..60_000 {
            meanwhile(self, &mut homing, cycle);
            match self.cycle(&mut homing) {
                Progress::Target(_) => {}
                end => {
                    self.settle();
                    return end;
                }
            }
        }
        panic!("no end after a minute: {homing:?}");
    }

    /// The homing is over: the axis rests, and stays where it is.
    fn settle(&mut self) {
        let before = self.rig.axis(0).sent_counts;
        self.rig.cycles(300);
        assert_eq!(self.rig.axis(0).sent_counts, before);
        assert_eq!(self.rig.axis(0).backlog_counts, 0);
        let now_ns = self.rig.bench.now_ns();
        assert_eq!(self.rig.drive(0).speed_rpm(now_ns), 0.0);
    }

    pub(crate) fn found(&mut self, config: Config) -> Home {
        match self.run(config, |_, _, _| {}) {
            Progress::Found(home) => home,
            other => panic!("{other:?} with {:?}", self.machine),
        }
    }

    pub(crate) fn failed(&mut self, config: Config) -> homing::Abort {
        match self.run(config, |_, _, _| {}) {
            Progress::Failed(abort) => abort,
            other => panic!("{other:?} with {:?}", self.machine),
        }
    }

    /// What the drive would report.
    pub(crate) fn position(&self) -> i32 {
        self.rig.drive(0).position_counts(self.rig.bench.now_ns()) as i32
    }
}
