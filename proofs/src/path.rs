//! A path of three axes: every kind of piece, every order, tables and machines.

use path::machine::{Backlash, Cartesian, DifferentialDrive, Gantry, Machine, Motor, Scale};
use path::tables::{Cam, CamPoint, Gear, TimePoint, TimeTable};
use path::{Arc, Join, Path};
use trajectory::units::Ratio;
use trajectory::{Limits, Position};

use crate::opaque::{bits, consume, flag, number, word};

type Tool = Path<Cartesian<3>, 3, 3, 16>;

/// Calls everything once.
pub fn exercise() {
    let Ok(scale) = Scale::from_fixed(bits().cast_signed()) else {
        return;
    };
    let machine = Cartesian { scales: [scale; 3] };
    let Some(limits) = limits() else { return };
    if let Ok(mut tool) = Tool::new(machine, [limits; 3], [position(); 3]) {
        along(&mut tool);
    }
    machines(scale);
    tables(&limits);
}

fn along(tool: &mut Tool) {
    tool.set_most_override(word() as u16);
    loop {
        let join = if flag() {
            Join::Blend(float())
        } else {
            Join::Exact
        };
        consume(tool.line([position(); 3], float(), join));
        let arc = Arc {
            plane: (number() as usize, number() as usize),
            centre: [position(); 2],
            sweep: bits().cast_signed(),
            end: [position(); 3],
        };
        consume(tool.arc(&arc, float(), Join::Rest));
        tool.set_override(word() as u16);
        match number() {
            0 => tool.pause(),
            1 => tool.resume(),
            2 => tool.stop(),
            _ => {}
        }
        consume(tool.advance());
        consume((tool.place(), tool.end(), tool.velocity()));
        consume((tool.is_done(), tool.has_room()));
        if flag() {
            return;
        }
    }
}

fn machines(scale: Scale) {
    let drive = DifferentialDrive {
        left: scale,
        right: Scale::ONE,
    };
    consume(drive.axes([position(); 2]));
    consume(drive.rates(&[float(); 2]));
    let motor = Motor {
        coordinate: word() as usize,
        scale,
    };
    let gantry = Gantry { motors: [motor; 3] };
    consume(gantry.axes([position(); 2]));
    consume(gantry.rates(&[float(); 2]));
    let Some(limits) = limits() else { return };
    if let Ok(mut play) = Backlash::new(position(), position(), limits) {
        consume(play.apply(position()));
        play.release();
        consume(play.is_there());
    }
}

fn tables(limits: &Limits) {
    let point = || CamPoint {
        master: number(),
        follower: number(),
    };
    let points = [point(), point(), point()];
    if let Ok(cam) = Cam::new(&points, float(), limits) {
        consume(cam.follower(position()));
    }
    let point = || TimePoint {
        cycle: word(),
        position: number(),
    };
    let points = [point(), point(), point()];
    if let Ok(table) = TimeTable::new(&points, limits) {
        consume(table.position(word()));
    }
    let Ok(ratio) = Ratio::new(number(), word()) else {
        return;
    };
    if let Ok(mut gear) = Gear::new(ratio, float(), *limits, limits) {
        gear.shift_to(position());
        consume(gear.follower(position()));
        consume(gear.phase());
    }
}

fn limits() -> Option<Limits> {
    Limits::new(float(), float(), float()).ok()
}

fn position() -> Position {
    Position::from_units(bits().cast_signed())
}

fn float() -> f32 {
    f32::from_bits(word())
}
