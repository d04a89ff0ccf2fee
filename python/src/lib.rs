//! What the Python package `motion_board` is made of: the crates of this project as functions and classes. The words for users are in the
//! Python files beside it; nothing here is called by users.

#![deny(unsafe_code)]

mod board_settings_text;
mod canopen;
mod dyn_can_codec;
mod dyn_serial_codec;
mod errors;
mod link;
mod log_decoder;
mod plan;
mod points;
mod simulated_board;
mod simulation;
mod values;

use pyo3::prelude::*;

/// The compiled part of `motion_board`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::board_settings_text::{fault_text, read_settings, settings_of_text};
    #[pymodule_export]
    use crate::canopen::{
        canopen_heartbeat, canopen_nmt, canopen_pdo, canopen_sdo_abort, canopen_sdo_read,
        canopen_sdo_value, canopen_sdo_write, canopen_sdo_written, canopen_sync,
    };
    #[pymodule_export]
    use crate::dyn_can_codec::{
        dyn_can_decode_reply, dyn_can_decode_request, dyn_can_encode_reply, dyn_can_encode_request,
    };
    #[pymodule_export]
    use crate::dyn_serial_codec::{
        SerialDecoder, dyn_serial_decode_reply, dyn_serial_decode_request, dyn_serial_encode_reply,
        dyn_serial_encode_request,
    };
    #[pymodule_export]
    use crate::link::Link;
    #[pymodule_export]
    use crate::log_decoder::{FrameDecoder, LogDecoder};
    #[pymodule_export]
    use crate::plan::plan;
    #[pymodule_export]
    use crate::simulated_board::SimulatedBoard;
    #[pymodule_export]
    use crate::simulation::simulate;
}
