//! The commissioning scripts, on a driver that does anything.

use can_motion::{Instant, service};
use dyn_can::Request;
use dyn_commission::{
    Ask, AssignId, ByteOrderProbe, Commissioner, CountAnswers, Group3Order, Scan, Script,
};

use crate::codec::{dialect, drive};
use crate::fake_can::FakeCan;
use crate::opaque::{self, consume};

/// Runs every script.
pub fn exercise() {
    let revision = dialect().revision;
    run(Scan::default());
    run(AssignId::rename(drive(), drive()));
    run(AssignId::first_id_of_the_only_drive(drive()));
    run(CountAnswers::of(drive()));
    run(Group3Order::of(drive()));
    run(Ask::new(drive(), Request::ReadDriveStatus, dialect()));
    run(ByteOrderProbe::with_free_shaft(drive(), revision));
}

fn run<S: Script<Result: Clone>>(script: S) {
    let mut commissioner = Commissioner::new(script);
    while opaque::flag() {
        let now = Instant::from_us(opaque::bits());
        commissioner.tick(now);
        consume(service(&mut commissioner, &mut FakeCan, now));
    }
    consume(commissioner.result().cloned());
}
