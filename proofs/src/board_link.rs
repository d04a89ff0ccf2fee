//! The buffer of timed set-points: every call, with any values in any order.

use board_link::{AxisLimits, Config, SetPointBuffer, WhenDry};
use trajectory::{Limits, Position, Time};

use crate::opaque::{bits, consume, flag, word};

const AXES: usize = 2;

/// Calls everything once.
pub fn exercise() {
    let float = || f32::from_bits(word());
    let Ok(motion) = Limits::new(float(), float(), float()) else {
        return;
    };
    let limits = AxisLimits {
        motion,
        lowest: position(),
        highest: position(),
    };
    let config = Config {
        longest_gap: Time::from_ticks(bits()),
        window: Time::from_ticks(bits()),
        when_dry: if flag() { WhenDry::End } else { WhenDry::Wait },
        ..Config::with_cycles_per_second(word())
    };
    let stand = [position(); AXES];
    let Some(mut buffer) = SetPointBuffer::<AXES, 64>::new(&[limits; AXES], &stand, config) else {
        return;
    };
    let mut positions = stand;
    while flag() {
        consume(buffer.push(Time::from_ticks(bits()), &[position(), position()]));
        consume(buffer.set_override(word() as u16));
        if flag() {
            buffer.pause();
        }
        if flag() {
            buffer.resume();
        }
        if flag() {
            buffer.stop();
        }
        if flag() {
            buffer.end();
        }
        consume(buffer.advance(&mut positions));
        consume(positions);
        consume((buffer.credit(), buffer.free(), buffer.buffered()));
        consume((buffer.time(), buffer.last_time(), buffer.phase()));
        consume((buffer.percent(), buffer.highest_percent()));
        consume((buffer.is_open(), buffer.is_paused(), buffer.axes()));
        consume(buffer.counters().refused_in_all());
    }
}

fn position() -> Position {
    Position::from_units(bits() as i64)
}
