//! ZLAC8030L wheels on the bus.

use can_motion::facts::Power;
use can_motion::plan::BitRate;
use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelFault, WheelLimits, WheelMasterConfig, WheelMode,
    WheelReactions, WheelTimeouts, Zlac,
};
use can_motion::{AxisState, Master};
use drive_sim::{FrameMatch, ReplyDamage, ZlacDrive, ZlacDriveConfig};
use embedded_can::{Frame as _, StandardId};
use host_tests::rig::{GROUP, WheelRig, wheel_config};
use zlac8030l::{DataFrame, NodeId};

use super::{Machine, id_of};

pub(crate) type Wheels = Machine<ZlacDrive, Zlac>;

pub(crate) const DISABLE_VOLTAGE: u16 = 0x0000;
pub(crate) const QUICK_STOP: u16 = 0x0002;
pub(crate) const ENABLE_OPERATION: u16 = 0x000F;

/// A wheel as the application declares it, and the drive that is really there.
#[derive(Clone)]
pub(crate) struct Hub {
    wheel: WheelConfig,
    drive: ZlacDriveConfig,
}

/// A wheel that follows speeds.
pub(crate) fn hub(node: i32) -> Hub {
    let node = NodeId::new(node).unwrap();
    Hub {
        wheel: wheel_config(node),
        drive: ZlacDriveConfig::new(node),
    }
}

pub(crate) fn hubs(count: i32) -> Vec<Hub> {
    (1..=count).map(hub).collect()
}

impl Hub {
    /// A wheel that moves to absolute positions by itself, at this speed.
    pub(crate) fn position(mut self, profile_speed_rpm: u16) -> Self {
        self.wheel.mode = WheelMode::Position { profile_speed_rpm };
        // The drive makes its own profile: a target may be anywhere.
        let most = zlac8030l::MoveKind::Absolute.limit();
        self.wheel.limits = WheelLimits {
            following_error: u32::MAX,
            ..WheelLimits::position(-most, most, 1_000_000, 20)
        };
        self
    }

    /// A wheel that follows torques up to 2 A, at 100 r/min at most.
    pub(crate) fn torque(mut self) -> Self {
        self.wheel.mode = WheelMode::Torque { slope_ma_s: 10_000 };
        self.wheel.limits = WheelLimits::torque(2_000, 2_000, 100);
        self
    }

    pub(crate) fn limits(mut self, change: impl Fn(&mut WheelLimits)) -> Self {
        change(&mut self.wheel.limits);
        self
    }

    pub(crate) fn react(mut self, change: impl Fn(&mut WheelReactions)) -> Self {
        change(&mut self.wheel.reactions);
        self
    }

    /// A load hangs on it, which the brake of the drive holds.
    pub(crate) fn load_can_fall(mut self) -> Self {
        self.wheel.load_can_fall = true;
        self
    }

    pub(crate) fn in_group(mut self, group: u8) -> Self {
        self.wheel.group = can_motion::GroupId(group);
        self
    }

    pub(crate) fn ramp_ms(mut self, ramp_ms: u16) -> Self {
        self.wheel.ramp_ms = ramp_ms;
        self
    }

    pub(crate) fn resolution(mut self, n: u16) -> Self {
        self.wheel.speed_resolution = n;
        self
    }

    pub(crate) fn firmware(mut self, firmware: zlac8030l::Firmware) -> Self {
        self.wheel.firmware = firmware;
        self
    }

    pub(crate) fn drive(mut self, change: impl Fn(&mut ZlacDriveConfig)) -> Self {
        change(&mut self.drive);
        self
    }
}

/// The bus, where it is not 100 Hz and 500 kbit/s.
#[derive(Clone, Copy)]
pub(crate) struct WheelLine(WheelMasterConfig);

pub(crate) fn wheel_line() -> WheelLine {
    WheelLine(WheelMasterConfig::DEFAULT)
}

impl WheelLine {
    pub(crate) fn cycle_us(mut self, cycle_us: u32) -> Self {
        self.0.cycle_us = cycle_us;
        self
    }

    pub(crate) fn kbit1000(mut self) -> Self {
        self.0.bit_rate = BitRate::Kbit1000;
        self
    }

    pub(crate) fn by_sync(mut self) -> Self {
        self.0.feedback = FeedbackTiming::Sync;
        self
    }

    pub(crate) fn feedback_ticks(mut self, ticks: u16) -> Self {
        self.0.feedback = FeedbackTiming::Timer { ticks };
        self
    }

    pub(crate) fn timeouts(mut self, change: impl Fn(&mut WheelTimeouts)) -> Self {
        change(&mut self.0.timeouts);
        self
    }

    /// Whether a master with much room takes these wheels; the text of its refusal.
    pub(crate) fn admits(&self, hubs: &[Hub]) -> Result<(), String> {
        let wheels: Vec<WheelConfig> = hubs.iter().map(|hub| hub.wheel).collect();
        Master::<64, Zlac>::new(self.0, &wheels)
            .map(|_| ())
            .map_err(|error| error.to_string())
    }
}

/// The frame with control word and target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Command {
    pub(crate) word: u16,
    pub(crate) target: i32,
    pub(crate) start_ns: u64,
}

impl Wheels {
    pub(crate) fn new(hubs: &[Hub]) -> Self {
        Self::on(wheel_line(), hubs)
    }

    pub(crate) fn on(line: WheelLine, hubs: &[Hub]) -> Self {
        let wheels: Vec<WheelConfig> = hubs.iter().map(|hub| hub.wheel).collect();
        let drives = hubs.iter().map(|hub| hub.drive.clone()).collect();
        Self(WheelRig::wheels(line.0, &wheels, drives))
    }

    /// The program starts anew with these settings; the drives stay as they are.
    pub(crate) fn start_anew(&mut self, hubs: &[Hub]) {
        let wheels: Vec<WheelConfig> = hubs.iter().map(|hub| hub.wheel).collect();
        self.0.master = Master::new(wheel_line().0, &wheels).unwrap();
    }

    pub(crate) fn streaming(hubs: &[Hub]) -> Self {
        let mut machine = Self::new(hubs);
        machine.stream();
        machine
    }

    /// Bits 0 to 3 of the status word: the motor holds, follows or brakes.
    pub(crate) fn energised(&self, axis: usize) -> bool {
        self.0.drive(axis).status_word(self.now_ns()) & 0xF == 0x7
    }

    pub(crate) fn is_operational(&self, axis: usize) -> bool {
        self.0.drive(axis).is_operational()
    }

    pub(crate) fn speed_rpm(&self, axis: usize) -> f64 {
        self.0.drive(axis).speed_rpm(self.now_ns())
    }

    pub(crate) fn travel(&self, axis: usize) -> i64 {
        self.0.drive(axis).travel_counts(self.now_ns())
    }

    /// What the master says of the drive's power: false also while it says that it does not know.
    pub(crate) fn believed_on(&self, axis: usize) -> bool {
        matches!(self.0.axis(axis).facts.power, Power::On | Power::FoundOn)
    }

    pub(crate) fn fault(&self, axis: usize) -> Option<WheelFault> {
        self.0.axis(axis).fault
    }

    pub(crate) fn all_stream(&self) -> bool {
        self.0.master.all_are(GROUP, AxisState::Streaming)
    }

    pub(crate) fn sent(&self, axis: usize) -> i32 {
        self.0.axis(axis).sent
    }

    /// True when the target was taken.
    pub(crate) fn set_target(&mut self, axis: usize, target: i32) -> bool {
        self.0.master.set_target(axis, target).is_ok()
    }

    /// Cycles with the same target for every wheel, whatever happens to it.
    pub(crate) fn drive_at(&mut self, targets: &[i32], cycles: usize) {
        for _ in 0..cycles {
            for (axis, target) in targets.iter().enumerate() {
                let _ = self.set_target(axis, *target);
            }
            self.run(1);
        }
    }

    pub(crate) fn faults_mut(&mut self, axis: usize) -> &mut drive_sim::ZlacFaults {
        self.0.drive_mut(axis).faults_mut()
    }

    pub(crate) fn node(&self, axis: usize) -> u16 {
        u16::from(self.0.axis(axis).node.get())
    }

    /// A frame comes in at this moment.
    pub(crate) fn comes_in(rig: &mut WheelRig, id: u16, data: &[u8]) {
        let frame = DataFrame::new(id, data).unwrap();
        let now = rig.now();
        can_motion::BusUser::on_frame(&mut rig.master, now, &frame);
    }

    pub(crate) fn bus_off(&mut self) {
        let now = self.0.now();
        self.0.master.on_bus_off(now);
    }

    pub(crate) fn bus_recovered(&mut self) {
        let now = self.0.now();
        self.0.master.on_bus_recovered(now);
    }

    /// The master does not get the next frames of a wheel with this base of the identifier.
    pub(crate) fn lose_frames_of(&mut self, axis: usize, base: u16, count: u32) {
        let which = FrameMatch::with_id(StandardId::new(base + self.node(axis)).unwrap());
        let node = self.0.node;
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .drop_next(node, which, count);
    }

    /// A wheel does not get its next commands.
    pub(crate) fn lose_commands_to(&mut self, axis: usize, count: u32) {
        let which = FrameMatch::with_id(StandardId::new(0x300 + self.node(axis)).unwrap());
        let node = self.0.bench.node_of(self.0.drives[axis]);
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .drop_next(node, which, count);
    }

    /// The transfer of a start with this number is answered with an abort (general error) and nothing else.
    pub(crate) fn abort_transfer(&mut self, axis: usize, number: usize) {
        let mut is_dropped = false;
        for _ in 0..400 {
            if self.transfers_since(0, axis).len() == number && !is_dropped {
                self.faults_mut(axis).damage_next_reply(ReplyDamage::Drop);
                is_dropped = true;
            }
            self.run(1);
            if let Some(request) = self.transfers_since(0, axis).get(number) {
                let reply = [0x80, request[1], request[2], request[3], 0, 0, 0, 8];
                let id = 0x580 + self.node(axis);
                self.0.cycle_with(|rig| Self::comes_in(rig, id, &reply));
                return;
            }
        }
        panic!("there is no transfer {number}");
    }

    /// Control words and targets to a wheel since a mark.
    pub(crate) fn commands_since(&self, mark: usize, axis: usize) -> Vec<Command> {
        let id = 0x300 + self.node(axis);
        self.frames_since(mark)
            .filter(|record| id_of(record) == id)
            .map(|record| match *record.frame.data() {
                [a, b, c, d, e, f] => Command {
                    word: u16::from_le_bytes([a, b]),
                    target: i32::from_le_bytes([c, d, e, f]),
                    start_ns: record.start_ns,
                },
                // A torque has two bytes.
                [a, b, c, d] => Command {
                    word: u16::from_le_bytes([a, b]),
                    target: i16::from_le_bytes([c, d]).into(),
                    start_ns: record.start_ns,
                },
                ref other => panic!("a command has four or six bytes: {other:02X?}"),
            })
            .collect()
    }

    /// Control words to a wheel since a mark, repeated ones once.
    pub(crate) fn words_since(&self, mark: usize, axis: usize) -> Vec<u16> {
        let commands = self.commands_since(mark, axis);
        let mut words: Vec<u16> = commands.iter().map(|command| command.word).collect();
        words.dedup();
        words
    }

    /// SDO requests of the master to a wheel since a mark.
    pub(crate) fn transfers_since(&self, mark: usize, axis: usize) -> Vec<Vec<u8>> {
        let id = 0x600 + self.node(axis);
        self.frames_since(mark)
            .filter(|record| id_of(record) == id)
            .map(|record| record.frame.data().to_vec())
            .collect()
    }
}

impl WheelLine {
    /// Sets up as many wheels as there are without drives: each request is answered as it likes best, and cycles begin.
    pub(crate) fn set_up_and_begin_cycles(&self, hubs: &[Hub]) {
        let wheels: Vec<WheelConfig> = hubs.iter().map(|hub| hub.wheel).collect();
        let mut master = Master::<64, Zlac>::new(self.0, &wheels).expect("accepted before");
        let drives = hubs.iter().map(|hub| hub.drive.clone());
        let (mut bench, _) =
            drive_sim::Bench::with_zlac_drives(drive_sim::BitRate::Kbit1000, drives);
        let node = bench.add_master(drive_sim::ControllerConfig::device());
        let cycle_ns = u64::from(self.0.cycle_us) * 1_000;
        for cycle in 1..=6_000 {
            let now = can_motion::Instant::from_us(bench.now_ns() / 1_000);
            master.begin_cycle(now);
            loop {
                let now = can_motion::Instant::from_us(bench.now_ns() / 1_000);
                let _ = can_motion::service(&mut master, &mut bench.port(node), now);
                if !bench.step_to(cycle * cycle_ns) {
                    break;
                }
            }
            if master.all_are(GROUP, AxisState::Ready) {
                return;
            }
        }
        panic!("the wheels are not set up");
    }
}
