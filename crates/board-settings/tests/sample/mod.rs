//! Settings for the tests.

use board_settings::{
    AxisSettings, BusSettings, Dialect, Inputs, MotorLimits, Name, Polls, ReadBack, Settings,
    Travel,
};
use proptest::prelude::*;

/// An axis that moves slowly by a quarter of a turn.
pub(crate) fn axis(drive: u8) -> AxisSettings {
    let limits = MotorLimits {
        speed_rpm: 150,
        acceleration_rpm_per_s: 1_000,
    };
    let travel = Travel::Millidegrees {
        min: -90_000,
        max: 90_000,
    };
    AxisSettings::new(drive, 4_096, limits, travel)
}

/// A board that works with drives 1, 2, ...
pub(crate) fn settings(axes: u8) -> Settings {
    Settings {
        name: Name::try_from("lathe").unwrap(),
        bus: BusSettings::new(1_000),
        inputs: Inputs::default(),
        axes: (1..=axes).map(axis).collect(),
    }
}

fn travel() -> impl Strategy<Value = Travel> {
    prop_oneof![
        any::<(i64, i64)>().prop_map(|(min, max)| Travel::Millidegrees { min, max }),
        any::<(i32, i32)>().prop_map(|(min, max)| Travel::Counts { min, max }),
    ]
}

fn read_back() -> impl Strategy<Value = ReadBack> {
    prop_oneof![
        Just(ReadBack::CommandCounts),
        Just(ReadBack::MovementPositions),
        Just(ReadBack::MotorSteps),
        any::<(u32, u32)>().prop_map(|(read_back_counts, command_counts)| ReadBack::Ratio {
            read_back_counts,
            command_counts
        }),
    ]
}

fn polls() -> impl Strategy<Value = Polls> {
    any::<[u32; 5]>().prop_map(|periods| Polls {
        status_us: periods[0],
        position_us: periods[1],
        torque_us: periods[2],
        speed_us: periods[3],
        counter_us: periods[4],
    })
}

fn any_axis() -> impl Strategy<Value = AxisSettings> {
    let numbers = any::<(u8, u16, u32, u32, Option<u32>, u8, Option<u32>, Option<u32>)>();
    let choices = prop_oneof![
        Just(Dialect::Detect),
        Just(Dialect::V1_2A),
        Just(Dialect::V1_6A)
    ];
    let flags = any::<(bool, bool)>();
    (numbers, travel(), read_back(), polls(), choices, flags).prop_map(
        |(numbers, travel, read_back, polls, dialect, (unwatched, load_can_fall))| AxisSettings {
            drive: numbers.0,
            gear: numbers.1,
            speed_rpm: numbers.2,
            acceleration_rpm_per_s: numbers.3,
            jerk_rpm_per_s2: numbers.4,
            travel,
            read_back,
            group: numbers.5,
            polls,
            unwatched,
            load_can_fall,
            dialect,
            following_error_counts: numbers.6,
            drift_tolerance_counts: numbers.7,
            homing: None,
        },
    )
}

/// Any settings that can be said.
pub(crate) fn any_settings() -> impl Strategy<Value = Settings> {
    let bus = any::<(u16, u8, u32, u32)>();
    let axes = prop::collection::vec(any_axis(), 0..=14);
    let name = "\\PC{0,6}|[a-z\"\\\\\t\n]{0,24}";
    (name, bus, any::<bool>(), axes).prop_map(|(name, bus, enable_fitted, axes)| Settings {
        name: Name::try_from(name.as_str()).unwrap_or_default(),
        bus: BusSettings {
            bit_rate_kbit_per_s: bus.0,
            requests_per_cycle: bus.1,
            response_min_us: bus.2,
            response_max_us: bus.3,
        },
        inputs: Inputs { enable_fitted },
        axes: axes.into_iter().collect(),
    })
}
