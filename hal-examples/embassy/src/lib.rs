//! The async driver of `embassy-stm32`: a task that awaits frames and cycles. The firmware of this project goes to the registers instead,
//! because the driver waits without an end where the master wants to know (`src/bus`).
#![no_std]
#![forbid(unsafe_code)]

use can_motion::plan::TxOrder;
use can_motion::{BusErrorKind, BusFrame, BusUser, Instant, Outcome};
use embassy_futures::select::{Either, select};
use embassy_stm32::can::frame::{Envelope, Frame};
use embassy_stm32::can::{Can, CanRx, CanTx};
use embassy_time::{Duration, Ticker};
use one_axis::{CYCLE_US, Refused, cycle, master};

fn now() -> Instant {
    Instant::from_us(embassy_time::Instant::now().as_micros())
}

/// Offers what is wanted until the mailboxes are full. `try_write` never waits, and gives back the frame that a more urgent one displaced.
fn send<U: BusUser>(user: &mut U, tx: &mut CanTx<'_>) {
    let _ = user.send(now(), &mut |frame: &U::Frame| {
        let Some(frame) = frame.to_can::<Frame>() else {
            return Outcome::Failed(BusErrorKind::Other);
        };
        match tx.try_write(&frame) {
            Ok(status) => match status.dequeued_frame().map(U::Frame::from_can) {
                Some(Ok(displaced)) => Outcome::Displaced(displaced),
                // Nothing was displaced, or a frame that is not the master's.
                Some(Err(_)) | None => Outcome::Accepted,
            },
            Err(embassy_stm32::can::TryWriteError::Full) => Outcome::Full,
        }
    });
}

fn take<U: BusUser>(user: &mut U, frame: &Frame) {
    match U::Frame::from_can(frame) {
        Ok(frame) => user.on_frame(now(), &frame),
        Err(error) => user.on_foreign_frame(now(), error),
    }
}

/// Waits for a frame, or an error of the bus.
async fn receive<U: BusUser>(user: &mut U, rx: &mut CanRx<'_>) {
    match rx.read().await {
        Ok(Envelope { frame, .. }) => take(user, &frame),
        Err(_) => user.on_receive_error(now(), BusErrorKind::Other),
    }
}

/// A task: runs for ever. Filters and bit rate of the controller are set.
///
/// # Errors
/// When the settings of the axis cannot work.
pub async fn run(mut can: Can<'static>) -> Result<(), Refused> {
    let mut master = master(TxOrder::Fifo)?;
    // Without it the mailboxes go out by identifier, and requests to low drives overtake set-points.
    can.set_tx_fifo_scheduling(true);
    can.enable().await;
    let (mut tx, mut rx) = can.split();
    let mut ticker = Ticker::every(Duration::from_micros(CYCLE_US.into()));
    for count in 0.. {
        cycle(&mut master, now(), count);
        send(&mut master, &mut tx);
        // Frames until the next cycle; each may let the master go on.
        while let Either::Second(()) = select(ticker.next(), receive(&mut master, &mut rx)).await {
            send(&mut master, &mut tx);
        }
    }
    Ok(())
}
