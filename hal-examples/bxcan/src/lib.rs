//! STM32F1, F4 and others with the controller bxCAN, over the crate `bxcan`.
//!
//! It implements `embedded_can::nb::Can`, and gives back the frame that a more urgent one displaces: `service` is all that is needed.
#![no_std]
#![forbid(unsafe_code)]

use bxcan::{Can, Fifo, FilterOwner, Instance, filter::Mask32};
use can_motion::plan::TxOrder;
use can_motion::{Instant, service};
use one_axis::{Refused, cycle, master};

/// Runs for ever. The controller has its bit timing; `now_us` is a clock that does not go back, and `is_cycle` is true once a cycle.
///
/// # Errors
/// When the settings of the axis cannot work.
pub fn run<I: Instance + FilterOwner>(
    mut can: Can<I>,
    now_us: impl Fn() -> u64,
    mut is_cycle: impl FnMut() -> bool,
) -> Result<(), Refused> {
    // Without a filter the controller receives nothing.
    can.modify_filters()
        .enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
    // The crate does not set the bit TXFP, so the mailboxes go out by identifier: the plan of the bus must know.
    let mut master = master(TxOrder::Identifier)?;
    for count in 0.. {
        cycle(&mut master, Instant::from_us(now_us()), count);
        while !is_cycle() {
            // Better from the interrupts of the controller.
            let _ = service(&mut master, &mut can, Instant::from_us(now_us()));
        }
    }
    Ok(())
}
