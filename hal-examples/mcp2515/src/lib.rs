//! A controller on SPI. The crate `mcp2515` implements `embedded_can::blocking::Can`, which says neither "full" nor "nothing came" but has
//! errors for both, so a sink of a few lines takes the place of `service`.
#![no_std]
#![forbid(unsafe_code)]

use can_motion::plan::TxOrder;
use can_motion::{BusErrorKind, BusFrame, BusUser, Instant, Outcome};
use embedded_hal::spi::SpiDevice;
use mcp2515::MCP2515;
use mcp2515::buffer::TxBuf;
use mcp2515::error::Error;
use mcp2515::frame::CanFrame;
use one_axis::{Refused, cycle, master};

/// Takes what came in, and sends what is wanted until the transmit buffer is full.
fn service<U: BusUser, S: SpiDevice<u8>>(user: &mut U, can: &mut MCP2515<S>, now: Instant) {
    loop {
        match can.read_message() {
            Ok(frame) => match U::Frame::from_can(&frame) {
                Ok(frame) => user.on_frame(now, &frame),
                Err(error) => user.on_foreign_frame(now, error),
            },
            Err(Error::NoMessage) => break,
            Err(_) => {
                user.on_receive_error(now, BusErrorKind::Other);
                break;
            }
        }
    }
    let _ = user.send(now, &mut |frame: &U::Frame| {
        let Some(frame) = frame.to_can::<CanFrame>() else {
            return Outcome::Failed(BusErrorKind::Other);
        };
        // One frame at a time: of several buffers the controller sends the highest first (MCP2515 data sheet, section 3.2), and frames
        // must go out in their order.
        match can.find_free_tx_buf() {
            Ok(TxBuf::B0) => {}
            Ok(_) | Err(Error::TxBusy) => return Outcome::Full,
            Err(_) => return Outcome::Failed(BusErrorKind::Other),
        }
        match can.send_message_via_buffer(TxBuf::B0, frame) {
            Ok(()) => Outcome::Accepted,
            // It may be in the buffer, and nobody knows whether it goes out: the master must know that.
            Err(_) => Outcome::Failed(BusErrorKind::Other),
        }
    });
}

/// Runs for ever. The controller is in normal mode; `now_us` is a clock that does not go back, and `is_cycle` is true once a cycle.
///
/// # Errors
/// When the settings of the axis cannot work.
pub fn run<S: SpiDevice<u8>>(
    mut can: MCP2515<S>,
    now_us: impl Fn() -> u64,
    mut is_cycle: impl FnMut() -> bool,
) -> Result<(), Refused> {
    let mut master = master(TxOrder::Fifo)?;
    for count in 0.. {
        cycle(&mut master, Instant::from_us(now_us()), count);
        while !is_cycle() {
            service(&mut master, &mut can, Instant::from_us(now_us()));
        }
    }
    Ok(())
}
