//! DYN servo drives on the bus.

use can_motion::facts::Power;
use can_motion::plan::{BusPlan, BusSetup, ResponseWindow, TxOrder};
use can_motion::{
    AxisConfig, AxisState, Confirmation, Dyn, Fault, MasterConfig, PollPeriods, Procedure,
    Reactions, ServoMaster, StepChange, Timeouts, Travel,
};
use drive_sim::{DynDrive, DynDriveConfig, FrameMatch};
use dyn_can::{
    CommandMode, ConfigByte, DataFrame, DriveConfig, DriveId, FunctionCode, GearNumber, MainGain,
    MaxSpeed, Request, ServoMode, SetParamGroup1, SetParamGroup2, SetParamGroup3, StepLimit,
};
use embedded_can::Frame as _;
use host_tests::rig::{GROUP, Rig, axis_config};

use super::{Machine, id_of};

pub(crate) type Servos = Machine<DynDrive, Dyn>;

/// A servo as the application declares it, and the drive that is really there.
#[derive(Clone)]
pub(crate) struct Servo {
    axis: AxisConfig,
    drive: DynDriveConfig,
}

/// A servo whose drive is off after power-on, so that whatever is on was switched on by the master.
pub(crate) fn servo(id: i32) -> Servo {
    let id = DriveId::new(id).unwrap();
    let drive = DynDriveConfig {
        enabled_after_power_on: false,
        ..DynDriveConfig::new(id)
    };
    Servo {
        axis: axis_config(id),
        drive,
    }
}

pub(crate) fn servos(count: i32) -> Vec<Servo> {
    (1..=count).map(servo).collect()
}

impl Servo {
    pub(crate) fn travel(mut self, min: i32, max: i32) -> Self {
        self.axis.limits.travel = Travel {
            min_counts: min,
            max_counts: max,
        };
        self
    }

    pub(crate) fn max_step(mut self, counts: i32) -> Self {
        self.axis.limits.max_step = StepLimit::new(counts).unwrap();
        self
    }

    pub(crate) fn ramp_change(mut self, counts: u16) -> Self {
        self.axis.limits.max_step_change = StepChange::from_counts(counts.into()).unwrap();
        self
    }

    /// What the master takes for the drive's own maximum speed and acceleration.
    pub(crate) fn curve(mut self, group: dyn_can::ParamGroup2) -> Self {
        self.axis.drive_curve = Some(group);
        self
    }

    pub(crate) fn backlog(mut self, counts: u32) -> Self {
        self.axis.limits.backlog_counts = counts;
        self
    }

    /// Nothing is read while the axis streams.
    pub(crate) fn without_polls(mut self) -> Self {
        self.axis.polls = PollPeriods::OFF;
        self
    }

    /// Nothing is read while the axis streams, and whoever configured it says that he knows.
    pub(crate) fn unwatched(mut self) -> Self {
        self.axis.unwatched = true;
        self.without_polls()
    }

    /// The diagnostic counter is read too, every 20 ms.
    pub(crate) fn counter_polled(mut self) -> Self {
        self.axis.polls.counter_us = Some(20_000);
        self
    }

    /// A load hangs on it.
    pub(crate) fn load_can_fall(mut self) -> Self {
        self.axis.load_can_fall = true;
        self
    }

    pub(crate) fn react(mut self, change: impl Fn(&mut Reactions)) -> Self {
        change(&mut self.axis.reactions);
        self
    }

    pub(crate) fn drive(mut self, change: impl Fn(&mut DynDriveConfig)) -> Self {
        change(&mut self.drive);
        self
    }

    /// The drive follows any step and does not mind, and the master neither: only the frames count.
    pub(crate) fn any_step(mut self) -> Self {
        self.axis.limits.following_error_counts = u32::MAX;
        self.axis.limits.drift_tolerance_counts = u32::MAX;
        self.drive(|drive| drive.lost_phase_steps = None)
    }

    /// The drive is in speed mode, in which no set-point may be sent to it.
    pub(crate) fn in_speed_mode(self) -> Self {
        self.drive(|drive| drive.config_byte = ConfigByte::from_byte(0x08))
    }
}

/// The bus, where it is not 1 kHz, 1 Mbit/s and first in, first out.
#[derive(Clone, Copy)]
pub(crate) struct Line {
    config: MasterConfig,
    order: drive_sim::TxOrder,
}

pub(crate) fn line() -> Line {
    Line {
        config: MasterConfig::DEFAULT,
        order: drive_sim::TxOrder::Fifo,
    }
}

impl Line {
    pub(crate) fn by_identifier(mut self) -> Self {
        self.order = drive_sim::TxOrder::ByIdentifier;
        self.config.bus.order = TxOrder::Identifier;
        self
    }

    pub(crate) fn cycle_us(mut self, cycle_us: u32) -> Self {
        self.config.cycle_us = cycle_us;
        self
    }

    pub(crate) fn responses_up_to_us(self, max_us: u32) -> Self {
        self.responses_us(0, max_us)
    }

    pub(crate) fn responses_us(mut self, min_us: u32, max_us: u32) -> Self {
        self.config.bus = BusSetup {
            response: ResponseWindow { min_us, max_us },
            ..self.config.bus
        };
        self
    }

    pub(crate) fn timeouts(mut self, change: impl Fn(&mut Timeouts)) -> Self {
        change(&mut self.config.timeouts);
        self
    }

    /// Whether the plan takes these servos; the text of its refusal.
    pub(crate) fn admits(&self, servos: &[Servo]) -> Result<(), String> {
        let axes: Vec<AxisConfig> = servos.iter().map(|servo| servo.axis).collect();
        ServoMaster::<16>::new(self.config, &axes)
            .map(|_| ())
            .map_err(|error| error.to_string())
    }

    /// Bits from the start of a cycle after which the set-point of an axis is through, by the plan.
    pub(crate) fn set_point_bound_bits(&self, servos: &[Servo], axis: usize) -> u32 {
        let axes: Vec<AxisConfig> = servos.iter().map(|servo| servo.axis).collect();
        let plan = BusPlan::new(&self.config, &axes);
        plan.set_point(axis).unwrap().bits.unwrap()
    }
}

/// What the master told a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    SetPoint(i32),
    On,
    Off,
    Reading(FunctionCode),
    /// About a motion that the drive makes by itself, with its number.
    Own(FunctionCode, i32),
    /// Writes the drive's memory or resets it.
    Write(FunctionCode),
}

/// A frame to an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ToDrive {
    pub(crate) axis: usize,
    pub(crate) told: Told,
    pub(crate) start_ns: u64,
    pub(crate) free_ns: u64,
}

/// Everything that writes a drive's memory or resets it.
pub(crate) fn writes() -> [(&'static str, Procedure); 6] {
    let group1 = SetParamGroup1 {
        main_gain: MainGain::new(17).ok(),
        ..SetParamGroup1::default()
    };
    let group2 = SetParamGroup2 {
        max_speed: MaxSpeed::new(17).ok(),
        max_acceleration: None,
    };
    let group3 = SetParamGroup3 {
        gear_number: GearNumber::new(2_048).ok(),
        ..SetParamGroup3::default()
    };
    let config = DriveConfig {
        command_mode: CommandMode::Rs232,
        absolute_mode: true,
        servo_mode: ServoMode::Position,
        servo_free: false,
    };
    [
        ("SetOrigin", Procedure::SetOrigin),
        ("DriveReset", Procedure::DriveReset),
        ("WriteGroup3", Procedure::WriteGroup3(group3)),
        ("WriteGroup2", Procedure::WriteGroup2(group2)),
        ("WriteGroup1", Procedure::WriteGroup1(group1)),
        ("WriteConfig", Procedure::WriteConfig(config)),
    ]
}

impl Servos {
    pub(crate) fn new(servos: &[Servo]) -> Self {
        Self::on(line(), servos)
    }

    pub(crate) fn on(line: Line, servos: &[Servo]) -> Self {
        let axes: Vec<AxisConfig> = servos.iter().map(|servo| servo.axis).collect();
        let drives = servos.iter().map(|servo| servo.drive.clone()).collect();
        Self(Rig::new(line.config, &axes, drives, line.order))
    }

    pub(crate) fn streaming(servos: &[Servo]) -> Self {
        let mut machine = Self::new(servos);
        machine.stream();
        machine
    }

    /// Whether the simulated drive is on.
    pub(crate) fn energised(&self, axis: usize) -> bool {
        self.0.drive(axis).is_enabled()
    }

    /// Counts of all set-points that the simulated drive took.
    pub(crate) fn taken(&self, axis: usize) -> i64 {
        self.0.drive(axis).commanded_counts()
    }

    /// What the master says of the drive's power: false also while it says that it does not know.
    pub(crate) fn believed_on(&self, axis: usize) -> bool {
        matches!(self.0.axis(axis).facts.power, Power::On | Power::FoundOn)
    }

    /// The master says that the drive is off.
    pub(crate) fn believed_off(&self, axis: usize) -> bool {
        matches!(self.0.axis(axis).facts.power, Power::Off | Power::OnWanted)
    }

    pub(crate) fn fault(&self, axis: usize) -> Option<Fault> {
        self.0.axis(axis).fault
    }

    /// Whether set-points go out now.
    pub(crate) fn streams(&self, axis: usize) -> bool {
        self.0.axis(axis).state == AxisState::Streaming
    }

    pub(crate) fn all_stream(&self) -> bool {
        self.0.master.all_are(GROUP, AxisState::Streaming)
    }

    pub(crate) fn eeprom_writes_counted(&self, axis: usize) -> u64 {
        self.0.axis(axis).counters.eeprom_writes.into()
    }

    pub(crate) fn eeprom_writes_made(&self, axis: usize) -> u64 {
        self.0.drive(axis).eeprom_writes().total()
    }

    pub(crate) fn target(&self, axis: usize) -> i32 {
        self.0.axis(axis).target_counts
    }

    /// True when the target was taken.
    pub(crate) fn set_target(&mut self, axis: usize, counts: i32) -> bool {
        self.0.master.set_target(axis, counts).is_ok()
    }

    /// Cycles with constant velocity of every axis, whatever happens to it; a target that is refused is forgotten.
    pub(crate) fn move_all(&mut self, steps: &[i32], cycles: i32) {
        let start: Vec<i32> = (0..steps.len()).map(|axis| self.target(axis)).collect();
        for cycle in 1..=cycles {
            for (axis, (start, step)) in start.iter().zip(steps).enumerate() {
                let _ = self.set_target(axis, start + step * cycle);
            }
            self.run(1);
        }
    }

    /// Starts a write or reset; the text of a refusal.
    pub(crate) fn start(&mut self, axis: usize, procedure: Procedure) -> Result<(), String> {
        let now = self.0.now();
        self.0
            .master
            .start(now, axis, procedure, Confirmation::Given)
            .map_err(|error| error.to_string())
    }

    pub(crate) fn faults_mut(&mut self, axis: usize) -> &mut drive_sim::DriveFaults {
        self.0.drive_mut(axis).faults_mut()
    }

    /// The drive does not get its next set-points, and nobody knows.
    pub(crate) fn lose_set_points(&mut self, axis: usize, count: u32) {
        let (node, id) = self.set_point_of(axis);
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .drop_next(node, id, count);
    }

    /// The drive gets its next set-points twice, and nobody knows.
    pub(crate) fn double_set_points(&mut self, axis: usize, count: u32) {
        let (_, id) = self.set_point_of(axis);
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .duplicate_next(id, count);
    }

    fn set_point_of(&self, axis: usize) -> (drive_sim::NodeId, FrameMatch) {
        let id = self.drive_id(axis).can_id(FunctionCode::GoRelativePosPd);
        let node = self.0.bench.node_of(self.0.drives[axis]);
        (
            node,
            FrameMatch::with_id(embedded_can::StandardId::new(id).unwrap()),
        )
    }

    fn drive_id(&self, axis: usize) -> DriveId {
        self.0.axis(axis).drive
    }

    /// A frame that the drive of an axis would send with this function and these bytes.
    pub(crate) fn reply_id(&self, axis: usize, function: FunctionCode) -> u16 {
        self.drive_id(axis).can_id(function)
    }

    /// A frame of the drive of an axis comes in at this moment.
    pub(crate) fn comes_in(rig: &mut Rig, axis: usize, function: FunctionCode, data: &[u8]) {
        let id = rig.axis(axis).drive.can_id(function);
        let frame = DataFrame::new(id, data).unwrap();
        let now = rig.now();
        can_motion::BusUser::on_frame(&mut rig.master, now, &frame);
    }

    /// Another master makes the present position the zero of a drive.
    pub(crate) fn stranger_sets_origin(&mut self, stranger: drive_sim::NodeId, axis: usize) {
        self.stranger_asks(stranger, axis, Request::SetOrigin);
    }

    /// Another master tells or asks a drive something.
    pub(crate) fn stranger_asks(
        &mut self,
        stranger: drive_sim::NodeId,
        axis: usize,
        request: Request,
    ) {
        let frame = self.request_frame(axis, request);
        self.stranger_sends(stranger, frame.id(), frame.data());
    }

    fn request_frame(&self, axis: usize, request: Request) -> DataFrame {
        let to = dyn_can::Address::Drive(self.drive_id(axis));
        request.encode(to, &dyn_can::Dialect::V1_6A).unwrap()
    }

    /// Another master switches a drive.
    pub(crate) fn stranger_switches(&mut self, stranger: drive_sim::NodeId, axis: usize, on: bool) {
        let frame = self.switch_frame(axis, on);
        self.stranger_sends(stranger, frame.id(), frame.data());
    }

    fn switch_frame(&self, axis: usize, on: bool) -> DataFrame {
        let switch = match on {
            true => dyn_can::ServoSwitch::Enable,
            false => dyn_can::ServoSwitch::Disable,
        };
        self.request_frame(axis, Request::ServoDisable(switch))
    }

    /// Cycles until the master has just asked an axis for this, and its drive has not answered yet. Drives of such a machine answer
    /// after more than a cycle.
    pub(crate) fn until_asked(
        &mut self,
        axis: usize,
        function: FunctionCode,
        mut cycle: impl FnMut(&mut Self),
    ) {
        for _ in 0..2_000 {
            let mark = self.mark();
            cycle(self);
            let asked = ToDrive {
                axis,
                told: Told::Reading(function),
                start_ns: 0,
                free_ns: 0,
            };
            let told = self.told_since(mark);
            if told
                .iter()
                .any(|to| (to.axis, to.told) == (asked.axis, asked.told))
            {
                return;
            }
        }
        panic!("axis {axis} is never asked {function:?}");
    }

    /// A reply of the drive of an axis comes in at this moment.
    pub(crate) fn reply_comes_in(rig: &mut Rig, axis: usize, reply: dyn_can::Reply) {
        let from = dyn_can::Address::Drive(rig.axis(axis).drive);
        let frame = reply.encode(from, &dyn_can::Dialect::V1_6A);
        let now = rig.now();
        can_motion::BusUser::on_frame(&mut rig.master, now, &frame);
    }

    /// The drive does not get its next commands to move to a position by itself, and nobody knows.
    pub(crate) fn lose_moves(&mut self, axis: usize, count: u32) {
        let id = self.drive_id(axis).can_id(FunctionCode::GoAbsolutePosPtp);
        let which = FrameMatch::with_id(embedded_can::StandardId::new(id).unwrap());
        let node = self.0.bench.node_of(self.0.drives[axis]);
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .drop_next(node, which, count);
    }

    /// The drive does not get its next commands to switch, and nobody knows.
    pub(crate) fn lose_switches(&mut self, axis: usize, count: u32) {
        let id = self.drive_id(axis).can_id(FunctionCode::ServoDisable);
        let which = FrameMatch::with_id(embedded_can::StandardId::new(id).unwrap());
        let node = self.0.bench.node_of(self.0.drives[axis]);
        self.0
            .bench
            .bus_mut()
            .faults_mut()
            .drop_next(node, which, count);
    }

    /// The controller gives a command of a procedure back unsent.
    pub(crate) fn command_comes_back(&mut self, axis: usize, request: Request) {
        let frame = self.request_frame(axis, request);
        let now = self.0.now();
        can_motion::BusUser::on_displaced(&mut self.0.master, now, &frame);
    }

    /// The controller gives a command to switch back unsent.
    pub(crate) fn switch_comes_back(&mut self, axis: usize, on: bool) {
        let frame = self.switch_frame(axis, on);
        let now = self.0.now();
        can_motion::BusUser::on_displaced(&mut self.0.master, now, &frame);
    }

    pub(crate) fn bus_off(&mut self) {
        let now = self.0.now();
        self.0.master.on_bus_off(now);
    }

    pub(crate) fn bus_recovered(&mut self) {
        let now = self.0.now();
        self.0.master.on_bus_recovered(now);
    }

    /// So many cycles begin, all at this moment, and nothing is sent in them.
    pub(crate) fn let_empty_cycles_pass(&mut self, cycles: u64) {
        let now = self.0.now();
        for _ in 0..cycles {
            self.0.master.begin_cycle(now);
        }
    }

    /// The parameters of group 3 as a drive with this gear number and on-position range would report them.
    pub(crate) fn group3_with(&self, axis: usize, gear: u16, range: u8) -> dyn_can::Reply {
        dyn_can::Reply::ParamGroup3(dyn_can::ParamGroup3 {
            gear_number: GearNumber::new(gear.into()).unwrap(),
            on_pos_range: dyn_can::OnPosRange::new(range.into()).unwrap(),
            ..self.0.drive(axis).config().group3
        })
    }

    /// What the master told its drives since a mark.
    pub(crate) fn told_since(&self, mark: usize) -> Vec<ToDrive> {
        self.frames_since(mark)
            // A trigger is for everybody.
            .filter(|record| id_of(record) >> 5 != 0)
            .map(|record| {
                let (id, data) = (id_of(record), record.frame.data());
                let drive = id >> 5;
                let axis = (0..self.drives())
                    .find(|axis| u16::from(self.drive_id(*axis).get()) == drive)
                    .expect("a drive of the machine");
                ToDrive {
                    axis,
                    told: told(FunctionCode::from_can_id(id), data),
                    start_ns: record.start_ns,
                    free_ns: record.free_ns,
                }
            })
            .collect()
    }

    /// Steps of the set-points to an axis since a mark.
    pub(crate) fn steps_since(&self, mark: usize, axis: usize) -> Vec<i32> {
        let told = self.told_since(mark).into_iter();
        told.filter(|to| to.axis == axis)
            .filter_map(|to| match to.told {
                Told::SetPoint(step) => Some(step),
                _ => None,
            })
            .collect()
    }

    /// Everything but readings that an axis was told since a mark, set-points left out.
    pub(crate) fn commands_since(&self, mark: usize, axis: usize) -> Vec<Told> {
        let told = self.told_since(mark).into_iter();
        told.filter(|to| to.axis == axis)
            .map(|to| to.told)
            .filter(|told| matches!(told, Told::On | Told::Off | Told::Write(_) | Told::Own(..)))
            .collect()
    }
}

fn told(function: FunctionCode, data: &[u8]) -> Told {
    use FunctionCode as F;
    match (function, data) {
        (F::GoRelativePosPd, &[byte]) => Told::SetPoint(i32::from(byte as i8)),
        (F::GoRelativePosPd, &[high, low]) => {
            Told::SetPoint(i32::from(i16::from_be_bytes([high, low])))
        }
        (F::ServoDisable, _) => {
            let frame = DataFrame::new(0x20 | function as u16, data).unwrap();
            match Request::decode(&frame, &dyn_can::Dialect::V1_6A) {
                Ok((_, Request::ServoDisable(dyn_can::ServoSwitch::Enable))) => Told::On,
                _ => Told::Off,
            }
        }
        (
            F::SetOrigin
            | F::DriveReset
            | F::SetDriveConfig
            | F::SetParamGroup1
            | F::SetParamGroup2
            | F::SetParamGroup3
            | F::AssignDriveId,
            _,
        ) => Told::Write(function),
        (
            F::GoAbsolutePosPtp
            | F::GoRelativePosPtp
            | F::GoAbsolutePosSync
            | F::GoRelativePosSync
            | F::TurnConstSpeed
            | F::SquareWave
            | F::SinWave,
            _,
        ) => Told::Own(function, number(data)),
        (F::SsFrequency, &[hertz]) => Told::Own(function, hertz.into()),
        _ => Told::Reading(function),
    }
}

/// A signed number of 1 to 4 bytes, the most significant first.
fn number(data: &[u8]) -> i32 {
    let first = data.first().map_or(0, |byte| i32::from(*byte as i8));
    let others = data.iter().skip(1);
    others.fold(first, |number, byte| number << 8 | i32::from(*byte))
}
