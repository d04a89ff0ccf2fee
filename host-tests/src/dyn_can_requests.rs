//! `dyn_can_requests.json`: typed request to frame and back.

use std::path::Path;

use dyn_can::{Address, DataFrame, Request, Revision, ZeroAddress};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::arguments;
use crate::frame_fields::{Command, HexBytes, RevisionField, address, data_frame};
use crate::options::Options;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "dyn_can_requests.json";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Vector {
    revision: RevisionField,
    drive_id: i32,
    command: Command,
    fc: u8,
    args: Map<String, Value>,
    can_id: u32,
    dlc: usize,
    data: HexBytes,
    #[serde(default)]
    options: Options,
}

/// Each request encodes to exactly the frame of its vector, and that frame decodes to the same request.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    let function = vector.command.0;
    let revision = Revision::from(vector.revision);
    same("fc", &vector.fc, &(function as u8))?;
    let expected = data_frame(vector.can_id, vector.dlc, &vector.data)?;
    let to = address(vector.drive_id).map_err(|error| refused(expected, error))?;
    let request = arguments::request(function, revision, vector.args)
        .map_err(|error| refused(expected, error))?;
    let dialect = vector.options.dialect(revision, permission(&request, to));
    let encoded = request
        .encode(to, &dialect)
        .map_err(|error| refused(expected, error))?;
    same("frame", &expected, &encoded)?;
    same(
        "decoded",
        &Ok((to, request)),
        &Request::decode(&expected, &dialect),
    )
}

/// The least permission that covers the request, so that a stop must pass with the permission for stops.
fn permission(request: &Request, to: Address) -> ZeroAddress {
    if to == Address::Broadcast && !request.may_be_broadcast(ZeroAddress::DisableAndSpeedZero) {
        ZeroAddress::LoneFreshDrive
    } else {
        ZeroAddress::DisableAndSpeedZero
    }
}

fn refused(expected: DataFrame, error: impl std::fmt::Display) -> Mismatch {
    Mismatch {
        expected: format!("frame {expected:?}"),
        actual: format!("refused: {error}"),
    }
}
