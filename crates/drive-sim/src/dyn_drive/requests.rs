//! What a drive does with a request.
//!
//! Specification: 1.6A and 1.2A, section 6. Motion commands need the servo on, no alarm, command mode 0 and the right servo mode (D45); whatever does not
//! meet these is ignored without a word. The configuration of the drive says where data errors come.

use dyn_can::units;
use dyn_can::{
    Alarm, Amplitude, CommandMode, ConfigByte, Counts28, DataFrame, DecodeError, DriveConfig,
    DriveError, DynFrame, FunctionCode, PdStep, Refusal, Reply, Request, Revision, ServoMode,
    ServoSwitch, SpeedRpm, StoredDriveId, SyncKind,
};

use super::DynDrive;
use super::reference::{Wave, WaveKind};
use super::settings::{RangeErrors, Reaction};

/// Time until a new id counts in revision 1.2A (1.2A section 6, #5; D33).
const NEW_ID_DELAY_NS: u64 = 10_000_000;

/// Servo mode bits of the configuration byte.
const SERVO_MODE_MASK: u8 = 0b0001_1000;

/// Servo mode bits for speed mode.
const SPEED_MODE: u8 = 0b0000_1000;

/// Motor steps in one turn, the unit of wave amplitudes by their angle: 2 x 4096 steps are 180 degrees.
const STEPS_PER_TURN: f64 = 16_384.0;

/// Registers of the built-in waves; both are 0 after power-on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WaveRegisters {
    shape: Option<(WaveKind, Amplitude)>,
    frequency_hz: u8,
}

/// Whether the chapter of a function promises a data error itself.
const fn repeats_the_promise(function: FunctionCode, revision: Revision) -> bool {
    use FunctionCode as F;
    match function {
        F::AssignDriveId => matches!(revision, Revision::V1_2A),
        F::GoAbsolutePosPtp
        | F::MakeLinearLine
        | F::GoRelativePosPtp
        | F::MakeCircularArc
        | F::TurnConstSpeed
        | F::SquareWave
        | F::SinWave
        | F::SsFrequency
        | F::SetParamGroup1
        | F::SetParamGroup2
        | F::SetParamGroup3
        | F::GoAbsolutePosSync
        | F::GoRelativePosSync => true,
        _ => false,
    }
}

/// Whether a request stores something.
const fn stores(request: &Request) -> bool {
    matches!(
        request,
        Request::SetOrigin
            | Request::AssignDriveId(_)
            | Request::SetDriveConfig(_)
            | Request::SetParamGroup1(_)
            | Request::SetParamGroup2(_)
            | Request::SetParamGroup3(_)
    )
}

impl DynDrive {
    /// Obeys a frame that is addressed to this drive.
    pub(super) fn obey_frame(&mut self, now_ns: u64, frame: &DataFrame) {
        match Request::decode(frame, &self.listening) {
            Ok((_, request)) => self.obey(now_ns, request),
            Err(error) => self.refuse(now_ns, frame.function(), error),
        }
    }

    fn refuse(&mut self, now_ns: u64, function: FunctionCode, error: DecodeError) {
        self.books.undecodable_frames += 1;
        if error == DecodeError::Refused(Refusal::Factory) {
            self.books.factory_frames += 1;
        }
        if self.reaction(function, error) == Reaction::DataError {
            self.books.data_errors += 1;
            let frame = self.encode(Reply::DriveError(DriveError::DataError));
            self.outbox.answer(now_ns, frame);
        }
    }

    fn reaction(&self, function: FunctionCode, error: DecodeError) -> Reaction {
        let is_promised = match self.config.range_errors {
            RangeErrors::EveryValue => true,
            RangeErrors::WhereRepeated => {
                repeats_the_promise(function, self.config.dialect.revision)
            }
        };
        match error {
            DecodeError::Refused(Refusal::Factory | Refusal::DriveOnly) => Reaction::Ignore,
            DecodeError::Range(_) if is_promised => Reaction::DataError,
            DecodeError::Range(_) => Reaction::Ignore,
            _ => self.config.unspecified,
        }
    }

    pub(super) fn obey(&mut self, now_ns: u64, request: Request) {
        if stores(&request) && !self.faults.takes_setting() {
            return;
        }
        match request {
            Request::GoRelativePosPd(step) => self.step(step),
            Request::GoAbsolutePosPtp(_)
            | Request::GoRelativePosPtp(_)
            | Request::GoAbsolutePosSync(_)
            | Request::GoRelativePosSync(_)
            | Request::SyncTrigger(_)
            | Request::TurnConstSpeed(_)
            | Request::SquareWave(_)
            | Request::SinWave(_) => self.obey_motion(request),
            // The sequence of words that makes a line or an arc is not documented for CAN (D56).
            Request::MakeLinearLine(_) | Request::MakeCircularArc(_) => {
                self.books.moves_ignored += 1;
            }
            Request::SsFrequency(frequency) => {
                self.wave.frequency_hz = frequency.get();
                self.update_wave();
            }
            Request::ServoDisable(switch) => self.switch_servo(switch),
            Request::SetOrigin => self.set_origin(),
            Request::AssignDriveId(id) => self.assign_id(now_ns, id),
            Request::SetDriveConfig(config) => self.store_config(config),
            Request::SetParamGroup1(set) => {
                self.registers.store_group1(set);
                self.update_limits();
            }
            Request::SetParamGroup2(set) => {
                self.registers.store_group2(set);
                self.update_limits();
            }
            Request::SetParamGroup3(set) => {
                self.registers.store_group3(set);
                self.update_limits();
            }
            Request::DriveReset => self.reset(now_ns),
            read => self.answer_read(now_ns, read),
        }
    }

    fn step(&mut self, step: PdStep) {
        if !self.takes_position_commands() {
            self.books.pd_frames_ignored += 1;
            return;
        }
        self.motion.step(step.get());
        self.books.pd_frames += 1;
        self.books.commanded_counts += i64::from(step.get());
    }

    fn obey_motion(&mut self, request: Request) {
        let obeyed = match request {
            Request::TurnConstSpeed(speed) => self.turn_at(speed),
            _ if !self.takes_position_commands() => false,
            Request::GoAbsolutePosPtp(target) => self.move_to(target.get()),
            Request::GoRelativePosPtp(distance) => self.move_by(distance.get()),
            Request::GoAbsolutePosSync(target) => {
                self.registers.loaded_absolute = Some(Counts28::get(target));
                true
            }
            Request::GoRelativePosSync(distance) => {
                self.registers.loaded_relative = Some(Counts28::get(distance));
                true
            }
            Request::SyncTrigger(kind) => self.trigger(kind),
            Request::SquareWave(amplitude) => self.shape_wave(WaveKind::Square, amplitude),
            Request::SinWave(amplitude) => self.shape_wave(WaveKind::Sine, amplitude),
            _ => true,
        };
        self.books.moves_ignored += u64::from(!obeyed);
    }

    fn move_to(&mut self, target: i32) -> bool {
        self.start_move(self.origin_counts + i64::from(target));
        true
    }

    fn move_by(&mut self, distance: i32) -> bool {
        let distance = i64::from(distance);
        self.books.relative_move_counts += distance;
        self.start_move(self.motion.target() + distance);
        true
    }

    fn start_move(&mut self, shaft_target: i64) {
        self.motion.go_to(shaft_target);
        self.books.moves += 1;
        self.books.last_move_target_counts = Some(shaft_target - self.origin_counts);
    }

    /// A loaded target starts one move; without one nothing happens (D57).
    fn trigger(&mut self, kind: SyncKind) -> bool {
        match kind {
            SyncKind::Absolute => self
                .registers
                .loaded_absolute
                .take()
                .is_some_and(|target| self.move_to(target)),
            SyncKind::Relative => self
                .registers
                .loaded_relative
                .take()
                .is_some_and(|distance| self.move_by(distance)),
        }
    }

    /// In 1.6A the drive switches itself to speed mode, in its working copy; the way back is a configuration write or power (D41).
    fn turn_at(&mut self, speed: SpeedRpm) -> bool {
        let config = self.registers.ram.config;
        let is_suitable = config.servo_mode_code() <= ServoMode::Speed as u8;
        if !self.takes_commands() || !is_suitable {
            return false;
        }
        if self.config.dialect.revision == Revision::V1_6A {
            let byte = config.to_byte() & !SERVO_MODE_MASK | SPEED_MODE;
            self.registers.ram.config = ConfigByte::from_byte(byte);
        }
        let counts_per_s = f64::from(speed.get()) * self.counts_per_s_of_rpm();
        self.motion.turn_at(counts_per_s, self.soft_start_s());
        true
    }

    fn shape_wave(&mut self, kind: WaveKind, amplitude: Amplitude) -> bool {
        self.wave.shape = Some((kind, amplitude));
        self.update_wave();
        true
    }

    fn update_wave(&mut self) {
        let WaveRegisters {
            shape,
            frequency_hz,
        } = self.wave;
        match shape {
            Some((kind, amplitude))
                if amplitude.get() > 0 && frequency_hz > 0 && self.takes_position_commands() =>
            {
                let gear = self.registers.ram.group3.gear_number;
                let counts_per_step =
                    f64::from(units::command_counts_per_turn(gear)) / STEPS_PER_TURN;
                self.motion.swing(Wave {
                    kind,
                    amplitude_counts: f64::from(amplitude.get()) * counts_per_step,
                    frequency_hz: f64::from(frequency_hz),
                });
            }
            _ => self.motion.stop_swinging(),
        }
    }

    fn switch_servo(&mut self, switch: ServoSwitch) {
        match switch {
            ServoSwitch::Disable => self.motion.release(),
            // Enabling what is enabled must not move the reference.
            ServoSwitch::Enable if self.alarm == Alarm::None && self.motion.is_free() => {
                self.lock()
            }
            ServoSwitch::Enable => {}
        }
    }

    /// Switches the servo on where the shaft is.
    pub(super) fn lock(&mut self) {
        if self.registers.ram.config.servo_mode_code() == ServoMode::Position as u8 {
            self.motion.hold();
        } else {
            self.motion.turn_at(0.0, self.soft_start_s());
        }
    }

    /// Time from one speed to another in speed mode (DYN2 manual A1.8 section 4.2).
    fn soft_start_s(&self) -> f64 {
        units::soft_start_s(self.registers.ram.group2.max_acceleration)
    }

    fn set_origin(&mut self) {
        self.origin_counts = self.motion.position();
        self.registers.writes.origin += 1;
    }

    fn assign_id(&mut self, now_ns: u64, id: StoredDriveId) {
        self.registers.store_id(id);
        if self.config.dialect.revision == Revision::V1_2A {
            self.registers.coming_id = Some((now_ns.saturating_add(NEW_ID_DELAY_NS), id));
        }
    }

    fn store_config(&mut self, config: DriveConfig) {
        let was = self.registers.ram.config;
        self.registers.store_config(config);
        self.follow_config(was);
    }

    /// Brings the servo in line with the configuration byte, which was `was`.
    pub(super) fn follow_config(&mut self, was: ConfigByte) {
        let config = self.registers.ram.config;
        let mode_changed = config.servo_mode_code() != was.servo_mode_code();
        let must_lock = was.servo_free() || mode_changed && !self.motion.is_free();
        if config.servo_free() {
            self.motion.release();
        } else if must_lock && self.alarm == Alarm::None {
            self.lock();
        }
    }

    /// 1.6A section 6, #27: clears a fault and resets the absolute position.
    fn reset(&mut self, now_ns: u64) {
        self.alarm = Alarm::None;
        self.last_alarm_frame_ns = None;
        self.origin_counts = self.motion.position();
        if !self.registers.ram.config.servo_free() {
            self.lock();
        }
        if let Some(byte) = self.config.reset_reply {
            self.reply(now_ns, Reply::DriveReset(byte));
        }
    }

    fn takes_commands(&self) -> bool {
        self.alarm == Alarm::None
            && !self.motion.is_free()
            && self.registers.ram.config.command_mode() == CommandMode::Rs232
    }

    pub(super) fn takes_position_commands(&self) -> bool {
        self.takes_commands()
            && self.registers.ram.config.servo_mode_code() == ServoMode::Position as u8
    }
}
