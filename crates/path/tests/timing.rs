mod independent;
use independent::rig::*;
use path::machine::{Cartesian, Scale};
use path::{Join, Path};
use trajectory::{Limits, Position};
#[test]
fn short() {
    let limits = Limits::new(1_650.0, 16.5, 0.33).unwrap();
    let scale = Scale::from_fixed(14_173_392_077).unwrap();
    for (size, tol) in [(200.0, 10.0), (20_000.0, 50.0), (20.0, 5.0), (4.0,1.0)] {
    let machine = Cartesian { scales: [scale; 3] };
    let mut tool: Path<_, 3, 3, 32> = Path::new(machine, [limits; 3], [Position::ZERO; 3]).unwrap();
    let mut n = 0; let mut rest = 0; let mut s = 12345u32;
    let mut r = || { s ^= s << 13; s ^= s >> 17; s ^= s << 5; (s >> 8) as f64 / 16777216.0 };
    let mut heading = 0.0;
    for cycle in 0..6000 {
        if tool.has_room() && cycle % 3 != 0 {
            n += 1;
            heading += (r()-0.5)*0.8;
            let e = units(tool.end());
            tool.line(place([e[0] + size*f64::cos(heading), e[1] + size*f64::sin(heading), e[2]]), 300.0, Join::Blend(tol)).unwrap();
        }
        tool.advance();
        if tool.is_at_rest() { rest += 1; }
    }
    println!("{size}: {n} pieces, {rest} cycles at rest, at {:?}", tool.velocity());
    }
}
