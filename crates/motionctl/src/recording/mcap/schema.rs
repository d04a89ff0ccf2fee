//! The JSON schemas of the messages.

use serde_json::{Value, json};

/// A message in the file.
pub(super) struct Schema {
    pub(super) name: &'static str,
    /// What a message is.
    description: &'static str,
    fields: &'static [Field],
}

struct Field {
    name: &'static str,
    /// Of JSON.
    kind: &'static str,
    /// Shape and unit.
    description: &'static str,
    /// Not in a message where it is not known.
    is_optional: bool,
}

const fn field(name: &'static str, kind: &'static str, description: &'static str) -> Field {
    Field {
        name,
        kind,
        description,
        is_optional: false,
    }
}

const fn optional(name: &'static str, kind: &'static str, description: &'static str) -> Field {
    Field {
        is_optional: true,
        ..field(name, kind, description)
    }
}

const TIME: Field = field(
    "time_s",
    "number",
    "seconds since the start of the recording",
);

pub(super) const CYCLE: Schema = Schema {
    name: "motionctl.Cycle",
    description: "One cycle of the master",
    fields: &[
        TIME,
        field(
            "number",
            "integer",
            "of the cycle on the clock; cycles that were missed are jumped over",
        ),
        field("bus_load", "number", "busy share of the bus, 0 to 1"),
        field(
            "late",
            "boolean",
            "a set-point was not on the bus in time, or the cycle began late",
        ),
    ],
};

pub(super) const AXIS: Schema = Schema {
    name: "motionctl.Axis",
    description: "One axis in one cycle",
    fields: &[
        TIME,
        optional("state", "string", "state of the axis in the master"),
        field(
            "target",
            "number",
            "where the application wants the axis, in the unit of the channel's metadata, as all that are not counts",
        ),
        field("sent", "number", "where the set-points sent take the drive"),
        optional(
            "position",
            "number",
            "where the motor stands, in cycles in which it is known",
        ),
        optional("following_error", "number", "target minus position"),
        field("target_counts", "integer", "command counts"),
        field("sent_counts", "integer", "command counts"),
        optional("position_counts", "integer", "command counts"),
        optional("following_error_counts", "integer", "command counts"),
        field(
            "backlog_counts",
            "integer",
            "target minus sent, command counts",
        ),
        optional("status_age_ms", "number", "age of the latest status"),
        optional("position_age_ms", "number", "age of the latest position"),
    ],
};

pub(super) const WHEEL: Schema = Schema {
    name: "motionctl.Wheel",
    description: "One wheel in one cycle",
    fields: &[
        TIME,
        optional("state", "string", "state of the wheel in the master"),
        field(
            "target",
            "number",
            "speed that the application wants, r/min",
        ),
        field("sent", "number", "speed of the latest set-point, r/min"),
        optional("speed", "number", "speed of the wheel, r/min"),
        optional("speed_error", "number", "target minus speed, r/min"),
        optional("status_age_ms", "number", "age of the latest status"),
        optional("position_age_ms", "number", "age of the latest position"),
    ],
};

pub(super) const FRAME: Schema = Schema {
    name: "motionctl.Frame",
    description: "One frame on the bus",
    fields: &[
        field(
            "time_s",
            "number",
            "end of the frame, seconds since the start of the recording",
        ),
        field("id", "integer", "identifier, 11 or 29 bits"),
        field("extended", "boolean", "whether the identifier has 29 bits"),
        field("remote", "boolean", "whether it is a remote frame"),
        field("data", "string", "two hexadecimal digits a byte"),
        optional("from_master", "boolean", "whether the master sent it"),
        field("text", "string", "what it says"),
        optional("failure", "string", "how it failed on the wire"),
    ],
};

pub(super) const EVENT: Schema = Schema {
    name: "motionctl.Event",
    description: "Something that happened",
    fields: &[
        TIME,
        field("kind", "string", "commanded, fault, notice, state or phase"),
        optional("axis", "string", "name of the axis; none for the whole bus"),
        optional("drive", "integer", "id of its drive"),
        field("text", "string", "what happened"),
    ],
};

impl Schema {
    /// As JSON schema.
    pub(super) fn text(&self) -> Value {
        let properties: serde_json::Map<String, Value> = self
            .fields
            .iter()
            .map(|field| {
                let value = json!({ "type": field.kind, "description": field.description });
                (field.name.to_owned(), value)
            })
            .collect();
        let required: Vec<&str> = self
            .fields
            .iter()
            .filter(|field| !field.is_optional)
            .map(|field| field.name)
            .collect();
        json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": self.name,
            "description": self.description,
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }
}
