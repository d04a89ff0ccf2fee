//! Where numbers and orders come to their edges: requests that are refused in every cycle, axes of few steps, cams beyond 32 bits.

use path::machine::{Backlash, Cartesian, Scale};
use path::tables::{Cam, CamPoint, Gear, TableError, TimePoint, TimeTable};
use path::{Join, Path, PathError};
use trajectory::units::Ratio;
use trajectory::{Limits, Position};

/// One axis with so many counts a unit.
fn path(counts: i64, limits: Limits) -> Path<Cartesian<1>, 1, 1, 24> {
    let scales = [Scale::from_fixed(counts << 32).unwrap()];
    Path::new(Cartesian { scales }, [limits], [Position::ZERO]).unwrap()
}

/// What is refused takes no time of the cycle from the preparation of what was taken.
#[test]
fn a_path_goes_on_whose_owner_asks_for_room_in_every_cycle() {
    let mut path = path(1, Limits::new(500.0, 2.0, 0.04).unwrap());
    let mut taken = 0;
    let mut refused = 0;
    for _ in 0..20_000 {
        if taken < 20 {
            let end = [Position::from_counts(1_000 * (taken + 1))];
            match path.line(end, 100.0, Join::Exact) {
                Ok(()) => taken += 1,
                Err(error) => {
                    assert_eq!(error, PathError::Full);
                    refused += 1;
                }
            }
        }
        path.advance();
    }
    assert!(path.is_done() && taken == 20 && refused > 0, "{taken}");
}

/// The acceleration is a few steps of the front: it brakes with as much as it has planned with.
#[test]
fn an_axis_whose_acceleration_is_a_few_steps_stops_within_its_limit() {
    for millimetres_per_s2 in [10.4, 15.3, 40.0] {
        // 131,072 counts a millimetre, cycles of a millisecond.
        let acceleration = millimetres_per_s2 * 1e-6 * 131_072.0;
        let limits = Limits::without_jerk(13_107.2, acceleration).unwrap();
        let mut path = path(131_072, limits);
        path.line([Position::from_counts(100)], 0.1, Join::Exact)
            .unwrap();
        let (mut at, mut step) = (0, 0);
        while !path.is_done() {
            let next = path.advance()[0].units();
            let change = (next - at - step) as f32 / Position::UNITS as f32;
            // A count more: the axis is rounded.
            assert!(
                change.abs() <= acceleration + 1.0,
                "{change} of {acceleration}"
            );
            (step, at) = (next - at, next);
        }
    }
}

/// Two units back are the rounding of a machine, no turn.
#[test]
fn a_released_backlash_stays_released_for_what_is_no_turn() {
    let limits = Limits::new(2.0, 0.5, 0.25).unwrap();
    let mut axis = Backlash::new(Position::ZERO, Position::from_counts(10), limits).unwrap();
    for counts in 0..=100 {
        axis.apply(Position::from_counts(counts)).unwrap();
    }
    let end = Position::from_units(100 * Position::UNITS - 2);
    for _ in 0..50 {
        axis.apply(end).unwrap();
    }
    axis.release();
    for _ in 0..50 {
        axis.apply(end).unwrap();
    }
    assert_eq!(axis.apply(end).unwrap(), end);
    // And a turn is one.
    for counts in (0..100).rev() {
        axis.apply(Position::from_counts(counts)).unwrap();
    }
    assert_ne!(axis.apply(Position::ZERO).unwrap(), Position::ZERO);
}

#[test]
fn a_cam_goes_on_beyond_32_bits() {
    let cam = |master, follower| CamPoint { master, follower };
    let points: Vec<CamPoint> = (0..=8)
        .map(|point| cam(point * 25_000_000, point * 250_000_000))
        .collect();
    let cam = Cam::new(&points, 2.0, &Limits::new(30.0, 1.0, 1.0).unwrap()).unwrap();
    for border in [100_000_000, 200_000_000, 400_000_000] {
        let at = |counts| cam.follower(Position::from_counts(border + counts)).units();
        let change = (at(2) - 2 * at(0) + at(-2)) as f32 / Position::UNITS as f32;
        assert!(change.abs() <= 1.0, "{border}: {change}");
    }
}

#[test]
fn a_gear_has_its_limit_in_both_directions() {
    let limits = Limits::new(20.0, 1.0, 1.0).unwrap();
    let shift = Limits::new(2.0, 0.1, 0.01).unwrap();
    let ratio = Ratio::new(3, 2).unwrap();
    for velocity in [14.0, -14.0] {
        let refused = Gear::new(ratio, velocity, shift, &limits).unwrap_err();
        assert!(
            matches!(refused, TableError::Velocity { .. }),
            "{refused:?}"
        );
        assert!(Gear::new(ratio, velocity / 2.0, shift, &limits).is_ok());
    }
}

/// The largest second difference over these cycles, and some of those behind.
fn roughness(table: &TimeTable<'_>, cycles: impl Iterator<Item = u32>) -> f64 {
    let at = |cycle| table.position(cycle).units() as f64 / Position::UNITS as f64;
    let bend = |cycle: u32| at(cycle) - 2.0 * at(cycle + 1) + at(cycle + 2);
    cycles.map(|cycle| bend(cycle).abs()).fold(0.0, f64::max)
}

/// Its share of the time has steps of 2^-32: what these make of the way to a point is no acceleration beyond the limit.
#[test]
fn a_table_with_too_long_a_way_between_two_points_is_refused() {
    let limits = Limits::without_jerk(20.0, 0.25).unwrap();
    let table = |cycle, position| {
        [(0, 0), (cycle, position)].map(|(cycle, position)| TimePoint { cycle, position })
    };
    for (cycle, position) in [(230_000_000, 2_000_000_000), (230_000_000, -2_000_000_000)] {
        let points = table(cycle, position);
        let refused = TimeTable::new(&points, &limits).unwrap_err();
        assert!(
            matches!(refused, TableError::LongWay { point: 0, .. }),
            "{refused}"
        );
    }
    for (cycle, position) in [(230_000_000, 170_000_000), (4_000_000_000, 100_000_000)] {
        let points = table(cycle, position);
        let table = TimeTable::new(&points, &limits).unwrap();
        let middle = (0..2_000).map(|place| cycle / 2 + place * 17);
        let rough = roughness(&table, middle);
        assert!(rough <= 0.25, "{rough}");
    }
}
