//! Linux: `with-socketcan can0`. The kernel's queue is deep and its times are those of the computer: for a machine see `motionctl run`.
#![forbid(unsafe_code)]

use std::error::Error;
use std::time::{Duration, Instant as Clock};

use can_motion::plan::TxOrder;
use can_motion::{Instant, service};
use one_axis::{CYCLE_US, cycle, master};
use socketcan::{CanSocket, Socket};

/// Half a minute of cycles.
const CYCLES: u32 = 30_000_000 / CYCLE_US;

fn main() -> Result<(), Box<dyn Error>> {
    let interface = std::env::args()
        .nth(1)
        .ok_or("expected a CAN network interface, as in: with-socketcan can0")?;
    let mut can = CanSocket::open(&interface)?;
    // `service` never waits.
    can.set_nonblocking(true)?;
    let mut master = master(TxOrder::Fifo).map_err(|refused| refused.0)?;
    let start = Clock::now();
    let now = || Instant::from_us(start.elapsed().as_micros() as u64);
    for count in 0..CYCLES {
        cycle(&mut master, now(), count);
        let end = Duration::from_micros(u64::from(CYCLE_US) * u64::from(count + 1));
        while start.elapsed() < end {
            let _ = service(&mut master, &mut can, now());
            std::thread::sleep(Duration::from_micros(100));
        }
        while let Some(event) = master.next_event() {
            println!("{} s, axis {:?}: {:?}", event.at, event.axis, event.kind);
        }
    }
    Ok(())
}
