//! A thin front end for async CAN drivers, beside `service` for the blocking ones. `cargo run -p can-motion --example async_front_end`
//!
//! The driver here is a queue; an embassy `CanTx`/`CanRx` pair or a SocketCAN stream has the same two methods.

use core::future::{Future, ready};
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use std::collections::VecDeque;

use can_motion::{
    AxisConfig, BusUser, Instant, Limits, MasterConfig, MotorLimits, Outcome, Progress,
    ServoMaster, Travel,
};
use dyn_can::{DriveId, DynFrame, FunctionCode, GearNumber};

/// What an async driver offers.
trait AsyncCan<Fr> {
    /// Sends a frame; ends when the controller has taken it.
    fn write(&mut self, frame: Fr) -> impl Future<Output = ()>;
    /// Waits for a frame.
    fn read(&mut self) -> impl Future<Output = Fr>;
}

/// One turn: everything that the user of the bus wants sent goes out in order, and what has come in is handed over.
///
/// The master is asked for one frame at a time and told that it was taken before the next `await`, so a front end that is dropped at an
/// `await` loses nothing: a frame counts once the driver has it.
async fn turn<U: BusUser>(user: &mut U, can: &mut impl AsyncCan<U::Frame>, now: Instant)
where
    U::Frame: Copy,
{
    loop {
        let mut taken = None;
        let progress = user.send(now, &mut |frame: &U::Frame| match taken {
            Some(_) => Outcome::Full,
            None => {
                taken = Some(*frame);
                Outcome::Accepted
            }
        });
        let Some(frame) = taken else { break };
        can.write(frame).await;
        if progress == Progress::Idle {
            break;
        }
    }
    while let Some(frame) = poll_once(can.read()) {
        user.on_frame(now, &frame);
    }
}

/// The output of a future that is ready.
fn poll_once<F: Future>(future: F) -> Option<F::Output> {
    let future = pin!(future);
    match future.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}

/// A driver for this example: it keeps what is sent and receives nothing.
struct Queue<Fr>(VecDeque<Fr>);

impl<Fr> AsyncCan<Fr> for Queue<Fr> {
    fn write(&mut self, frame: Fr) -> impl Future<Output = ()> {
        self.0.push_back(frame);
        ready(())
    }

    fn read(&mut self) -> impl Future<Output = Fr> {
        core::future::pending()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (drive, gear) = (DriveId::new(1)?, GearNumber::new(4_096)?);
    let config = MasterConfig::DEFAULT;
    let slow = MotorLimits {
        speed_rpm: 60,
        acceleration_rpm_per_s: 300,
    };
    let limits = Limits::of_motor(slow, Travel::WHOLE, gear, config.cycle_us)?;
    let mut master = ServoMaster::<1>::new(config, &[AxisConfig::new(drive, gear, limits)])?;
    let mut can = Queue(VecDeque::new());
    for ms in 0..3_000_u64 {
        let now = Instant::from_us(ms * 1_000);
        master.begin_cycle(now);
        let _ = poll_once(turn(&mut master, &mut can, now));
    }
    let frames = can.0;
    println!(
        "a master whose drive does not answer sent {} frames",
        frames.len()
    );
    // It asks again and again, and moves and switches nothing.
    let asks = [FunctionCode::EchoFunction, FunctionCode::ReadDriveStatus];
    assert!(frames.len() > 10 && frames.iter().all(|frame| asks.contains(&frame.function())));
    Ok(())
}
