//! Homings with any configuration and any readings.

use homing::{
    AfterPowerLoss, Config, Direction, Frame, HardStop, Homing, Inputs, Level, Method,
    PositionMemory, Progress, Reading, Switch, Travel, Watch,
};
use trajectory::Limits;

use crate::opaque::{bits, consume, flag, float, maybe, number, pick, word};

/// Runs a homing.
pub fn exercise() {
    let (Some(search), Some(slow)) = (limits(), limits()) else {
        return;
    };
    let config = Config {
        method: method(),
        cycle_us: word(),
        search,
        slow,
        way_counts: word(),
        back_off_counts: word(),
        reference_counts: number(),
        travel: travel(),
        watch: Watch {
            max_age_us: word(),
            settle_us: word(),
            still_counts: word(),
        },
    };
    consume(config.reach(number()));
    match Homing::new(config, number()) {
        Ok(homing) => run(homing),
        Err(refusal) => consume(refusal),
    }
    frames();
}

fn run(mut homing: Homing) {
    while flag() {
        let inputs = Inputs {
            sent_counts: number(),
            position: maybe(reading(number())),
            torque_permille: maybe(reading(number() as i16)),
            switch: maybe(reading(flag())),
        };
        match homing.cycle(bits(), &inputs) {
            Progress::Target(counts) => consume(counts),
            Progress::Found(home) => consume(home),
            Progress::Failed(abort) => consume(abort),
        }
        if flag() {
            homing.cancel();
        }
    }
}

fn frames() {
    let frame = Frame::new(number(), travel()).with_drive_zero(number(), number());
    consume((frame.to_drive(number()), frame.to_axis(number())));
    consume((frame.to_axis_inside(number()), frame.travel_of_drive()));
    let memory = pick([
        PositionMemory::Incremental,
        PositionMemory::MovesToStoredZero,
        PositionMemory::MultiTurn,
    ]);
    consume(AfterPowerLoss::of(memory));
}

fn method() -> Method {
    let direction = pick([Direction::Positive, Direction::Negative]);
    match word() {
        0 => Method::Here,
        1 => Method::HardStop(HardStop {
            direction,
            contact_permille: word() as u16,
            most_permille: word() as u16,
            contact_counts: word(),
            most_counts: word(),
            repeat_counts: word(),
        }),
        _ => Method::Switch(Switch {
            direction,
            operated: pick([Level::Low, Level::High]),
            most_counts: word(),
            most_permille: maybe(word() as u16),
        }),
    }
}

fn travel() -> Travel {
    Travel {
        min_counts: number(),
        max_counts: number(),
    }
}

fn limits() -> Option<Limits> {
    Limits::new(float() as f32, float() as f32, float() as f32).ok()
}

fn reading<T>(value: T) -> Reading<T> {
    Reading {
        value,
        at_us: bits(),
    }
}
