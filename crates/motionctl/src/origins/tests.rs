use super::*;

const GEAR: i32 = 4_096;

fn axis() -> HomedAxis {
    HomedAxis {
        drive: 3,
        gear_number: GEAR,
        method: "stop".to_owned(),
        homed: "2026-11-29T08:00:00Z".parse().unwrap(),
        origin_counts: -1_000,
        uncertainty_counts: 1,
        min_counts: 0,
        max_counts: 100_000,
        after_power_loss: AfterPowerLoss::HomeAgain,
        position_counts: 5_000,
        counter: 40,
    }
}

fn life() -> Life {
    Life {
        gear: GearNumber::new(GEAR).unwrap(),
        first_counter: 41,
        last_counter: 44,
        position_counts: 5_010,
        is_absolute: false,
    }
}

#[test]
fn an_origin_holds_as_long_as_the_counter_goes_on() {
    assert_eq!(axis().check(&life()), Ok(()));
    // Up to three replies may have been lost, and the counter wraps.
    for (counter, first_counter, holds) in [
        (40, 44, true),
        (40, 45, false),
        (40, 40, false),
        (255, 0, true),
        (40, 0, false),
    ] {
        let axis = HomedAxis { counter, ..axis() };
        let life = Life {
            first_counter,
            ..life()
        };
        assert_eq!(
            axis.check(&life).is_ok(),
            holds,
            "{counter} {first_counter}"
        );
    }
}

#[test]
fn another_gear_a_zero_and_a_place_outside_spoil_it() {
    let spoilt = |life: Life| axis().check(&life).unwrap_err();
    let gear = GearNumber::new(2_048).unwrap();
    assert_eq!(
        spoilt(Life { gear, ..life() }),
        Spoilt::Gear {
            expected: 4_096,
            actual: 2_048
        }
    );
    let zero = Life {
        position_counts: -3,
        ..life()
    };
    assert_eq!(
        spoilt(zero),
        Spoilt::Zeroed {
            before_counts: 5_000
        }
    );
    let below = Life {
        position_counts: -1_001,
        ..life()
    };
    assert!(matches!(spoilt(below), Spoilt::Outside(error) if error.actual_counts == -1));
}

#[test]
fn a_file_comes_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("origins.toml");
    let mut origins = Origins::read_or_begin(&path).unwrap();
    origins.put(HomedAxis { drive: 7, ..axis() }).unwrap();
    origins.put(axis()).unwrap();
    let mut origins = Origins::read(&path).unwrap();
    assert_eq!(origins.axes, [axis(), HomedAxis { drive: 7, ..axis() }]);
    let drive = DriveId::new(3).unwrap();
    let taken = origins.take(drive, &life()).unwrap();
    assert_eq!((taken.counter, taken.position_counts), (44, 5_010));
    // The same look again is one whose counter did not go on.
    let mut origins = Origins::read(&path).unwrap();
    let spoilt = origins.take(drive, &life());
    assert!(
        matches!(spoilt, Err(OriginsError::Spoilt { .. })),
        "{spoilt:?}"
    );
    origins.forget(drive).unwrap();
    let mut origins = Origins::read(&path).unwrap();
    assert!(matches!(
        origins.take(drive, &life()),
        Err(OriginsError::Missing { .. })
    ));
}

#[test]
fn what_is_wrong_in_a_file_is_named_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("origins.toml");
    let mut origins = Origins::read_or_begin(&path).unwrap();
    origins.put(axis()).unwrap();
    let good = std::fs::read_to_string(&path).unwrap();
    for (from, to, expected) in [
        ("format = 1", "format = 2", "expected format = 1, got 2"),
        (
            "drive = 3",
            "drive = 64",
            "expected a drive id of 1..=63, got 64",
        ),
        (
            "gear-number = 4096",
            "gear-number = 1",
            "expected a gear number of 500..=16384, got 1",
        ),
        (
            "min-counts = 0",
            "min-counts = 100001",
            "expected min-counts below max-counts",
        ),
        ("counter = 40", "counter = 400", "expected u8"),
        ("counter = 40", "", "counter"),
        (
            "counter = 40",
            "counter = 40\nspeed = 1",
            "unknown field `speed`",
        ),
        ("counter = 40", "counter = 40\n[[axis", "line"),
    ] {
        assert!(good.contains(from), "{good}");
        std::fs::write(&path, good.replacen(from, to, 1)).unwrap();
        let error = Origins::read(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert!(error.contains("origins.toml, line "), "{error}");
    }
}
