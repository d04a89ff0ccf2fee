//! Requests that are answered.
//!
//! Specification: 1.6A and 1.2A, section 6. A reply tells the state at the end of its request, and repeats the identifier of the function (D5).

use dyn_can::units;
use dyn_can::{DriveStatus, ReadSelector, Reply, Request, Torque};

use super::DynDrive;
use super::config::LOST_PHASE_STEPS;
use super::motion::Motion;

impl DynDrive {
    pub(super) fn answer_read(&mut self, now_ns: u64, request: Request) {
        let ram = self.registers.ram;
        let reply = match request {
            Request::ReadDriveId => Reply::DriveId(ram.id),
            Request::ReadDriveConfig => Reply::DriveConfig(ram.config),
            Request::ReadDriveStatus => Reply::DriveStatus(self.status(now_ns)),
            Request::GeneralRead(ReadSelector::Position) => Reply::Position(self.read_back(now_ns)),
            Request::GeneralRead(ReadSelector::Torque) => Reply::Torque(self.torque(now_ns)),
            Request::ReadParamGroup1 => Reply::ParamGroup1(ram.group1),
            Request::ReadParamGroup2 => Reply::ParamGroup2(ram.group2),
            Request::ReadParamGroup3 => Reply::ParamGroup3(ram.group3),
            // A number beyond 16 bits ends at the end of its range.
            Request::ReadMotorSpeed => Reply::MotorSpeed(self.speed_rpm(now_ns).round() as i16),
            Request::EchoFunction(bytes) => Reply::Echo(bytes),
            Request::DiagnosticCounter => {
                Reply::DiagnosticCounter(self.registers.count_diagnostic())
            }
            _ => return,
        };
        self.reply(now_ns, reply);
    }

    pub(super) fn reply(&mut self, now_ns: u64, reply: Reply) {
        let frame = self.encode(reply);
        let fault = self.faults.next_reply();
        self.books.replies += 1;
        let is_sent = self.outbox.reply(now_ns, frame, fault);
        self.books.unsent_frames += u64::from(!is_sent);
    }

    pub(super) fn status_of(&self, motion: &Motion) -> DriveStatus {
        let group = self.registers.ram.group3;
        let steps = motion.error().abs() * units::gear_ratio(group.gear_number);
        let on_position = steps <= f64::from(group.on_pos_range.get());
        DriveStatus::new(on_position, motion.is_free(), self.alarm, motion.is_busy())
    }

    pub(super) fn torque(&self, now_ns: u64) -> Torque {
        let full_scale = self.config.dialect.torque_full_scale;
        let positive = self.config.dialect.positive_torque;
        let steps = self.config.lost_phase_steps.unwrap_or(LOST_PHASE_STEPS);
        let gear_ratio = units::gear_ratio(self.registers.ram.group3.gear_number);
        let full_error = f64::from(steps.max(1)) / gear_ratio;
        let share = self.motion.at(now_ns).torque_share(full_error);
        // A share within -1 ..= 1 always has a torque.
        Torque::from_share(share, full_scale, positive).unwrap_or(Torque {
            raw: 0,
            full_scale,
            positive,
        })
    }
}
