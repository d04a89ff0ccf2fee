//! The frames of a command, for `--dry-run`.

use zlac8030l::{DataFrame, NmtRequest, NodeId, SdoRequest, dictionary};

use super::object::address_text;
use crate::drives::{Step, When};

/// A transfer.
pub(super) fn transfer(when: When, node: NodeId, request: SdoRequest) -> Step {
    let address = request.address();
    let object = dictionary::find(address).map_or("", |entry| entry.name);
    let does = match request {
        SdoRequest::Read(_) => "read",
        SdoRequest::Write(..) => "write",
        SdoRequest::Abort(..) => "abort",
    };
    let value = match request {
        SdoRequest::Write(_, data) => {
            let entry = dictionary::find(address);
            let value = entry.and_then(|entry| entry.data_type.value(data).ok());
            value.map_or(String::new(), |value| format!(" = {value}"))
        }
        SdoRequest::Read(_) | SdoRequest::Abort(..) => String::new(),
    };
    Step {
        when,
        hex: candump(&request.encode(node)),
        words: format!(
            "to node {node}: {does} {}{value}  ({object})",
            address_text(address)
        ),
    }
}

/// An NMT command.
pub(super) fn command(when: When, request: NmtRequest, words: &str) -> Step {
    Step {
        when,
        hex: candump(&request.encode()),
        words: words.to_owned(),
    }
}

fn candump(frame: &DataFrame) -> String {
    let data: String = frame
        .data()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    format!("{:03X}#{data}", frame.id())
}
