//! What the schema of a line of `motionctl decode --json` says of the meaning of a frame; `can-decode` writes it.

use schemars::JsonSchema;

/// The protocol, and what it says of the frame.
#[derive(JsonSchema)]
#[serde(tag = "protocol", rename_all = "snake_case")]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) enum MeaningFields {
    /// A message of the DYN drives.
    Dyn(DynFields),
    /// A message of CANopen.
    Canopen(CanopenFields),
    /// A frame that no drive on this bus sends or hears.
    Foreign {
        /// Why.
        error: String,
    },
}

/// A message of the DYN drives. One more entry for each value of the message, whose name ends in its unit, as `step_counts`.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct DynFields {
    /// Id of the drive; null where it is not known, as on the identifiers of all drives.
    drive: Option<u8>,
    direction: Direction,
    /// Name of the function, as the documents print it.
    function: String,
    /// From the request to this reply.
    #[serde(skip_serializing_if = "Option::is_none")]
    response_us: Option<f64>,
    /// Why it does not decode.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// What is remarkable about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// A message of CANopen.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct CanopenFields {
    /// Node; null for a message to all.
    node: Option<u8>,
    direction: Option<Direction>,
    /// Name of the service.
    service: String,
    /// Index and sub-index of each object in it, and its number.
    objects: Vec<(String, i64)>,
    /// From the request to this reply.
    response_ns: Option<u64>,
    /// It looks like trouble.
    remarkable: bool,
}

/// Which side sent it.
#[derive(JsonSchema)]
#[serde(rename_all = "snake_case")]
#[expect(dead_code, reason = "only its shape is used")]
enum Direction {
    ToDrive,
    FromDrive,
}

/// Smallest, mean and largest of a series.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "only its shape is used")]
pub(super) struct SpreadFields {
    least_us: f64,
    mean_us: f64,
    most_us: f64,
}
