//! Frames of one wheel on their way out, and back.

use zlac8030l::{CanopenFrame, DataFrame, NmtCommand, NmtRequest, SdoRequest, Service, objects};

use super::axis::{Log, Reset, Wheel};
use super::config::WheelMasterConfig;
use super::event::WheelEventKind;
use super::process_data;
use crate::family::{Life, Sends, Switch};
use crate::life::{AxisState, Reason};
use crate::time::Instant;

/// Something that goes out in the gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelRequest {
    /// A command of network management.
    Nmt(NmtCommand),
    /// The start of a transfer.
    Transfer(SdoRequest),
    /// The abort of a transfer that was given up.
    Abort(SdoRequest),
}

impl Sends for Wheel {
    fn sends_each_cycle(&self) -> bool {
        self.is_set_up && self.state.is_known()
    }

    fn set_point(&self) -> (DataFrame, i32) {
        let value = self.books.next(self.config.limits.max_step);
        let config = &self.config;
        let frame = process_data::command(config.node, config.mode, self.control_word(), value);
        (frame, value)
    }

    /// The same frame: control word and target travel together.
    fn switch_frame(&self, _: Switch) -> Option<DataFrame> {
        Some(self.set_point().0)
    }

    fn wanted_request(&self, _: u32) -> Option<(WheelRequest, i32)> {
        let urgent = |request| Some((request, i32::MAX));
        if let Some(abort) = self.abort {
            return urgent(WheelRequest::Abort(abort));
        }
        if self.nmt_due && !self.is_lost() {
            return urgent(WheelRequest::Nmt(match self.state {
                AxisState::CheckingStatus => NmtCommand::Start,
                _ => NmtCommand::PreOperational,
            }));
        }
        let request = self.wanted_transfer()?;
        let is_ready = self.sdo.ready(self.now.as_us(), request.address()).is_ok();
        is_ready.then_some((WheelRequest::Transfer(request), i32::MAX))
    }

    fn request_frame(&self, request: WheelRequest) -> Option<DataFrame> {
        let node = self.config.node;
        Some(match request {
            WheelRequest::Nmt(command) => NmtRequest {
                command,
                node: Some(node),
            }
            .encode(),
            WheelRequest::Transfer(request) | WheelRequest::Abort(request) => request.encode(node),
        })
    }

    fn stepped(&mut self, value: i32, _: Instant) {
        self.books.accepted(value);
        self.edge = !self.edge;
        self.counters.set_points = self.counters.set_points.wrapping_add(1);
    }

    fn switched(&mut self, switch: Switch, log: &mut Log<'_>) {
        self.may_be_enabled = switch == Switch::Enable;
        let next = match switch {
            Switch::Enable => AxisState::ConfirmingEnable,
            Switch::Disable => AxisState::ConfirmingDisable,
        };
        self.enter(next, Reason::Sent, log);
    }

    fn requested(
        &mut self,
        request: WheelRequest,
        _: u32,
        _: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) {
        self.counters.requests = self.counters.requests.wrapping_add(1);
        match request {
            WheelRequest::Nmt(_) => self.nmt_due = false,
            WheelRequest::Abort(_) => self.abort = None,
            WheelRequest::Transfer(request) => {
                // It was ready when it was offered, and time has only passed since.
                let _ = self.sdo.start(log.now.as_us(), request);
                if self.wanted == Some(request) {
                    self.wanted = None;
                }
            }
        }
    }

    fn displaced(&mut self, frame: &DataFrame, _: u32, log: &mut Log<'_>) -> bool {
        self.counters.displaced = self.counters.displaced.wrapping_add(1);
        match frame.service() {
            Ok(Service::Rpdo(..)) => {
                log.push(WheelEventKind::TargetDisplaced);
                return false;
            }
            Ok(Service::SdoRequest(_)) => self.withdraw(frame),
            Ok(Service::Nmt) => self.nmt_due = true,
            _ => {
                log.push(WheelEventKind::ForeignFrame { id: frame.id() });
                return false;
            }
        }
        log.push(WheelEventKind::RequestDisplaced);
        true
    }

    /// Any later frame says the same or more.
    fn owes_set_point(&self) -> bool {
        true
    }

    fn merged(&mut self) {
        self.counters.merged = self.counters.merged.wrapping_add(1);
    }
}

impl Wheel {
    /// The transfer that the state needs, or else the one that the application asked for.
    fn wanted_transfer(&self) -> Option<SdoRequest> {
        match self.state {
            AxisState::Probing => Some(objects::DEVICE_TYPE.read()),
            AxisState::Identifying => Some(objects::SPEED_RESOLUTION.read()),
            AxisState::CheckingConfig => self.script.wanted(&self.steps()),
            AxisState::CheckingStatus => match self.reset {
                Reset::No => None,
                Reset::Allowed => Some(objects::FAULT_CODE.read()),
                Reset::Edge => {
                    Some(objects::CONTROL_WORD.write(zlac8030l::ControlWord::FAULT_RESET.get()))
                }
                Reset::Release => {
                    Some(objects::CONTROL_WORD.write(zlac8030l::ControlWord::DISABLE_VOLTAGE.get()))
                }
            },
            _ if self.is_lost() => None,
            _ => self.wanted,
        }
    }

    /// The controller gave a request back: no reply will come.
    fn withdraw(&mut self, frame: &DataFrame) {
        let Ok((_, request)) = SdoRequest::decode(frame) else {
            return;
        };
        if matches!(request, SdoRequest::Abort(..)) {
            self.abort = Some(request);
            return;
        }
        self.sdo.withdraw();
        if self.wanted.is_none() && self.state.may_poll() {
            self.wanted = Some(request);
        }
    }
}
