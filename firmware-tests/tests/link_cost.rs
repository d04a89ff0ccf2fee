//! What a busy link costs the cycle.

use firmware_tests::motion::Drives;
use firmware_tests::orders::{self, Handlers};
use firmware_tests::rig;

#[test]
fn figures() {
    let drives = Drives {
        count: 4,
        response_us: 500,
    };
    let (mut rig, mut host) = orders::enabled(rig::image("link"), drives);
    let standing = Handlers::count(&mut rig, 1_000, |rig| host.run_ms(rig, 1));
    orders::set_moving(&mut rig, &mut host, 6_000);
    let moving = Handlers::count(&mut rig, 2_000, |rig| host.run_ms(rig, 1));
    println!(
        "standing {standing:?}, moving {moving:?} {:?}",
        rig.board().accounts().loads()
    );
    println!("{:?}", host.told);
}
