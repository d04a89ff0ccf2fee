//! The database of DYN CAN (DBC), as far as a DBC can say the protocol: one message for each identifier.

use std::fmt::{self, Write as _};

use dyn_can::{Address, ByteOrder, DriveId, FunctionCode, Revision};

use super::dbc_layout::{Layout, Signal, layout};

/// What a DBC cannot say otherwise.
const COMMENT: &str = "\
DYN CAN, the protocol of the DYN2 and DYN4 servo drives, made of the tables of the crate dyn-can. Not the vendor's file.\n\
What a DBC cannot say:\n\
- Numbers of Go_..., Turn_ConstSpeed, Square_Wave, Sin_Wave and General_Read have 1 to 4 bytes by the length of the frame, the first \
byte highest: their messages have no signals.\n\
- A request and its reply share one identifier. Where the request has no data the signals are those of the reply; a frame without \
data is the request, and has none of them.\n\
- What a General_Read reply is, position or torque, only its request says.\n\
- The Read_Param_Group3 reply is the one of revision 1.6A with the lowest byte first, as printed; drives may send the highest first \
(on_pos_range is out of range then), and 1.2A sends five bytes.\n\
- 0 in a Set_Param_Group request keeps what is stored.\n\
- Data that a drive refuses is shown like any other.\n\
motionctl decode and dyn-can.lua know all of it.";

/// The text of the file.
#[must_use]
pub fn database() -> String {
    let mut text = String::new();
    write(&mut text).expect("a string has room");
    text
}

fn write(to: &mut String) -> fmt::Result {
    writeln!(
        to,
        "VERSION \"\"\n\nNS_ :\n\tCM_\n\tVAL_\n\nBS_:\n\nBU_: Master Drive\n"
    )?;
    each_message(|address, function| write_message(to, address, function))?;
    writeln!(to, "CM_ \"{COMMENT}\";")?;
    each_message(|address, function| write_comment(to, address, function))?;
    each_message(|address, function| write_values(to, address, function))
}

fn each_message(mut write: impl FnMut(Address, FunctionCode) -> fmt::Result) -> fmt::Result {
    let drives = DriveId::all().map(Address::Drive);
    for address in std::iter::once(Address::Broadcast).chain(drives) {
        // No master may send it, and no drive does.
        for function in FunctionCode::ALL
            .into_iter()
            .filter(|function| *function != FunctionCode::ForMotorDefine)
        {
            write(address, function)?;
        }
    }
    Ok(())
}

fn write_message(to: &mut String, address: Address, function: FunctionCode) -> fmt::Result {
    let Layout { bytes, signals } = layout(function);
    let (sender, receiver) = parties(function);
    let id = address.can_id(function);
    write!(to, "BO_ {id} ")?;
    match address {
        Address::Broadcast => write!(to, "All_")?,
        Address::Drive(drive) => write!(to, "D{:02}_", drive.get())?,
    }
    writeln!(to, "{}: {bytes} {sender}", function.name())?;
    for signal in &signals {
        write_signal(to, signal, receiver)?;
    }
    writeln!(to)
}

/// Who sends the frame that the signals are of, and who hears it.
fn parties(function: FunctionCode) -> (&'static str, &'static str) {
    let is_of = |request: bool| {
        let admits = |revision| match request {
            true => function.admit_request(revision).is_ok(),
            false => function.admit_reply(revision).is_ok(),
        };
        admits(Revision::V1_2A) || admits(Revision::V1_6A)
    };
    let is_either = matches!(
        function,
        FunctionCode::GeneralRead | FunctionCode::DriveReset | FunctionCode::EchoFunction
    );
    match (is_either, is_of(false)) {
        (true, _) => ("Vector__XXX", "Vector__XXX"),
        (_, true) => ("Drive", "Master"),
        (_, false) => ("Master", "Drive"),
    }
}

fn write_signal(to: &mut String, signal: &Signal, receiver: &str) -> fmt::Result {
    let Signal {
        name,
        first_bit,
        bits,
        order,
        is_signed,
        factor,
        offset,
        limits: (min, max),
        unit,
        ..
    } = *signal;
    let order = match order {
        ByteOrder::MsbFirst => 0,
        ByteOrder::LsbFirst => 1,
    };
    let sign = if is_signed { '-' } else { '+' };
    writeln!(
        to,
        " SG_ {name} : {first_bit}|{bits}@{order}{sign} ({factor},{offset}) [{min}|{max}] \"{unit}\" {receiver}"
    )
}

fn write_comment(to: &mut String, address: Address, function: FunctionCode) -> fmt::Result {
    let Layout { bytes, signals } = layout(function);
    let id = address.can_id(function);
    if signals.is_empty() {
        writeln!(
            to,
            "CM_ BO_ {id} \"A signed number of 1 to {bytes} bytes: no signal can say it.\";"
        )?;
    }
    match function {
        FunctionCode::DriveReset => writeln!(
            to,
            "CM_ BO_ {id} \"1.6A only. FE is the request; the answer is explained by no document.\";"
        ),
        FunctionCode::EchoFunction => {
            writeln!(
                to,
                "CM_ BO_ {id} \"The reply has the bytes of the request.\";"
            )
        }
        _ => Ok(()),
    }
}

fn write_values(to: &mut String, address: Address, function: FunctionCode) -> fmt::Result {
    for signal in &layout(function).signals {
        if signal.values.is_empty() {
            continue;
        }
        write!(to, "VAL_ {} {}", address.can_id(function), signal.name)?;
        for (value, meaning) in signal.values {
            write!(to, " {value} \"{meaning}\"")?;
        }
        writeln!(to, " ;")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use dyn_can::Quantity;

    use super::*;

    #[test]
    fn every_signal_is_within_its_message_and_has_a_place_of_its_own() {
        for function in FunctionCode::ALL {
            let Layout { bytes, signals } = layout(function);
            let mut taken = 0_u64;
            for signal in signals {
                let mask = signal.mask();
                assert_eq!(taken & mask, 0, "{function}: {}", signal.name);
                assert_eq!(
                    mask.checked_shr(8 * u32::from(bytes)).unwrap_or(0),
                    0,
                    "{function}: {}",
                    signal.name
                );
                taken |= mask;
            }
        }
    }

    #[test]
    fn a_status_is_written_as_the_documents_have_it() {
        let mut text = String::new();
        write_message(
            &mut text,
            Address::Drive(DriveId::MIN),
            FunctionCode::ReadDriveStatus,
        )
        .unwrap();
        assert_eq!(
            text,
            "BO_ 41 D01_Read_Drive_Status: 1 Drive\n \
             SG_ on_position : 0|1@1+ (-1,1) [0|1] \"\" Master\n \
             SG_ disabled : 1|1@1+ (1,0) [0|1] \"\" Master\n \
             SG_ alarm_code : 2|3@1+ (1,0) [0|7] \"\" Master\n \
             SG_ motion_busy : 5|1@1+ (1,0) [0|1] \"\" Master\n\n"
        );
    }

    #[test]
    fn limits_are_those_of_the_codec() {
        let signals = layout(FunctionCode::ReadParamGroup3).signals;
        assert_eq!(signals[1].limits, Quantity::GearNumber.limits());
    }
}
