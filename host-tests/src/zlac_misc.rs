//! `zlac_misc.json`: NMT, heartbeat, PDO, command sequences, status words and fault codes of the ZLAC8030L.

use std::path::Path;

use serde::Deserialize;
use zlac8030l::{
    DataFrame, FaultCode, Heartbeat, MappingEntry, NmtCommand, NmtRequest, NmtState, ObjectAddress,
    ObjectData, PdoMapping, PdoNumber, SdoRequest, State, StatusWord, dictionary,
};

use crate::frame_fields::HexBytes;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;
use crate::zlac_sdo::{Code, RefusedFrame, data_frame, decode_refused, expect_refusal, node_id};

/// The file name.
pub const FILE: &str = "zlac_misc.json";

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Command {
    Start,
    Stop,
    PreOperational,
    ResetNode,
    ResetCommunication,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum NodeState {
    BootUp,
    Stopped,
    Operational,
    PreOperational,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum PowerState {
    NotEnabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    Undocumented,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Mode {
    Velocity,
    Position,
    Torque,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct StatusFields {
    state: PowerState,
    emergency_stop: bool,
    running: bool,
    external_emergency_stop: bool,
    target_reached: bool,
    #[serde(default)]
    zero_speed: Option<bool>,
    #[serde(default)]
    target_valid: Option<bool>,
    #[serde(default)]
    bit13: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    can_id: u16,
    data: HexBytes,
}

/// The fields of a PDO vector.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pdo {
    number: usize,
    node: i32,
    objects: Vec<(u16, u8)>,
    values: Vec<i64>,
    can_id: u16,
    dlc: usize,
    data: HexBytes,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Vector {
    Nmt {
        command: Command,
        node: i32,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    Heartbeat {
        node: i32,
        state: NodeState,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    RefuseHeartbeat {
        frame: RefusedFrame,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
    RefuseNmt {
        frame: RefusedFrame,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
    Tpdo(Pdo),
    Rpdo(Pdo),
    Sequence {
        steps: Vec<Step>,
    },
    StatusWord {
        mode: Mode,
        word: u16,
        fields: StatusFields,
    },
    Fault {
        code_word: u16,
        names: Vec<String>,
    },
}

/// Each vector holds in both directions, where it has two.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    match vector {
        Vector::Nmt {
            command,
            node,
            can_id,
            dlc,
            data,
        } => {
            let node = if node == 0 {
                None
            } else {
                Some(node_id(node)?)
            };
            let request = NmtRequest {
                command: command.into(),
                node,
            };
            let frame = data_frame(can_id, dlc, &data)?;
            same("frame", &frame, &request.encode())?;
            same("decoded", &Ok(request), &NmtRequest::decode(&frame))
        }
        Vector::Heartbeat {
            node,
            state,
            can_id,
            dlc,
            data,
        } => {
            let heartbeat = Heartbeat {
                node: node_id(node)?,
                state: state.into(),
            };
            let frame = data_frame(can_id, dlc, &data)?;
            same("frame", &frame, &heartbeat.encode())?;
            same("decoded", &Ok(heartbeat), &Heartbeat::decode(&frame))
        }
        Vector::RefuseHeartbeat { frame, code, .. } | Vector::RefuseNmt { frame, code, .. } => {
            expect_refusal(code, decode_refused(&frame))
        }
        Vector::Tpdo(pdo) => check_pdo(&pdo, true),
        Vector::Rpdo(pdo) => check_pdo(&pdo, false),
        Vector::Sequence { steps } => check_sequence(&steps),
        Vector::StatusWord { mode, word, fields } => {
            same("fields", &fields, &fields_of(mode, StatusWord::new(word)))
        }
        Vector::Fault { code_word, names } => {
            let ours: Vec<&str> = FaultCode::new(code_word).names().collect();
            same(
                "names",
                &names,
                &ours.into_iter().map(String::from).collect(),
            )
        }
    }
}

fn check_pdo(pdo: &Pdo, to_master: bool) -> Result<(), Mismatch> {
    same("values", &pdo.objects.len(), &pdo.values.len())?;
    let node = node_id(pdo.node)?;
    let number = *PdoNumber::ALL
        .get(pdo.number)
        .ok_or_else(|| Mismatch::unreadable("a PDO beyond 3"))?;
    let mut entries = Vec::new();
    let mut values = Vec::new();
    for ((index, sub), value) in pdo.objects.iter().zip(&pdo.values) {
        let address = ObjectAddress::new(*index, *sub);
        let entry = dictionary::find(address)
            .ok_or_else(|| Mismatch::unreadable(format!("no {address}")))?;
        same("mappable", &true, &entry.mappable)?;
        entries.push(MappingEntry::new(address, entry.data_type));
        values.push(
            entry
                .data_type
                .data(*value)
                .ok_or_else(|| Mismatch::unreadable("a value beyond its type"))?,
        );
    }
    let mapping = PdoMapping::new(&entries).map_err(Mismatch::unreadable)?;
    let frame = data_frame(pdo.can_id, pdo.dlc, &pdo.data)?;
    let ours = if to_master {
        mapping.tpdo(node, number, &values)
    } else {
        mapping.rpdo(node, number, &values)
    };
    same("frame", &frame, &ours)?;
    let decoded = mapping.values(&frame).map_err(Mismatch::unreadable)?;
    let decoded: Vec<ObjectData> = decoded.into_iter().flatten().collect();
    same("decoded", &values, &decoded)
}

/// Every step is a write that the dictionary admits, and encodes to the same bytes.
fn check_sequence(steps: &[Step]) -> Result<(), Mismatch> {
    same("empty", &false, &steps.is_empty())?;
    for step in steps {
        let frame = DataFrame::new(step.can_id, &step.data.0).map_err(Mismatch::unreadable)?;
        let (node, request) = SdoRequest::decode(&frame).map_err(Mismatch::unreadable)?;
        let SdoRequest::Write(address, data) = request else {
            return Err(Mismatch::unreadable("a step that writes nothing"));
        };
        let entry = dictionary::find(address)
            .ok_or_else(|| Mismatch::unreadable(format!("no {address}")))?;
        let value = entry.data_type.value(data).map_err(Mismatch::unreadable)?;
        same("request", &Ok(request), &entry.write(value))?;
        same("frame", &frame, &request.encode(node))?;
    }
    Ok(())
}

fn fields_of(mode: Mode, word: StatusWord) -> StatusFields {
    let is = |wanted: bool, value: bool| wanted.then_some(value);
    let (velocity, position) = (
        matches!(mode, Mode::Velocity),
        matches!(mode, Mode::Position),
    );
    StatusFields {
        state: match word.state() {
            State::NotEnabled => PowerState::NotEnabled,
            State::ReadyToSwitchOn => PowerState::ReadyToSwitchOn,
            State::SwitchedOn => PowerState::SwitchedOn,
            State::OperationEnabled => PowerState::OperationEnabled,
            State::Undocumented => PowerState::Undocumented,
        },
        emergency_stop: word.emergency_stop(),
        running: word.running(),
        external_emergency_stop: word.external_emergency_stop(),
        target_reached: word.target_reached(),
        zero_speed: is(velocity, word.zero_speed()),
        target_valid: is(position, word.target_valid()),
        bit13: is(position, word.deviation()),
    }
}

impl From<Command> for NmtCommand {
    fn from(command: Command) -> Self {
        match command {
            Command::Start => Self::Start,
            Command::Stop => Self::Stop,
            Command::PreOperational => Self::PreOperational,
            Command::ResetNode => Self::ResetNode,
            Command::ResetCommunication => Self::ResetCommunication,
        }
    }
}

impl From<NodeState> for NmtState {
    fn from(state: NodeState) -> Self {
        match state {
            NodeState::BootUp => Self::BootUp,
            NodeState::Stopped => Self::Stopped,
            NodeState::Operational => Self::Operational,
            NodeState::PreOperational => Self::PreOperational,
        }
    }
}
