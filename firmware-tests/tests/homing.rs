//! Two axes that are homed before they move: one to a hard stop, one to a switch on a pin of the board.

use drive_sim::{DynDriveConfig, EndStops, Mechanics, Switch, SwitchSide};
use firmware_tests::{Contact, Rig, rig};

/// Where the stop and the switch are, in counts from where the shafts stand at power-on.
const STOP: i64 = -1_500;
const SWITCH: i64 = 1_200;
/// How far the axes back off.
const BACK: i64 = 400;

/// Drives 1 and 2, with what each meets.
fn machine(stop: Option<i64>, switch: i64) -> Rig {
    let config = |id| DynDriveConfig::numbered(id).expect("an id is 1 to 63");
    let first = DynDriveConfig {
        mechanics: Mechanics {
            stops: stop.map(|low_counts| EndStops {
                low_counts,
                high_counts: 1 << 30,
            }),
            switch: None,
        },
        ..config(1)
    };
    let second = DynDriveConfig {
        mechanics: Mechanics {
            stops: None,
            switch: Some(Switch {
                at_counts: switch,
                side: SwitchSide::Above,
            }),
        },
        ..config(2)
    };
    let mut rig = Rig::with_drives(rig::image("homing"), [first, second]);
    rig.make_ready();
    rig.enable();
    rig
}

/// Runs with the switch of drive 2 on its pin, until the log has this text; false when it has not after so long.
fn run_until(rig: &mut Rig, text: &str, most_ms: u64) -> bool {
    for _ in 0..most_ms {
        let now_ns = rig.board().soc().now_ns();
        let switch = rig.servos().nth(1).expect("drive 2");
        if switch.switch_is_operated(now_ns) {
            rig.close(Contact::Homing);
        } else {
            rig.open(Contact::Homing);
        }
        rig.run_ms(1);
        if rig.board().log().iter().any(|line| line.contains(text)) {
            return true;
        }
    }
    false
}

fn positions(rig: &Rig) -> Vec<i64> {
    let now_ns = rig.board().soc().now_ns();
    rig.servos()
        .map(|drive| drive.position_counts(now_ns))
        .collect()
}

#[test]
fn the_axes_are_homed_one_after_the_other_and_then_they_move() {
    let mut rig = machine(Some(STOP), SWITCH);
    let before = rig.commanded_counts();
    rig.run_ms(300);
    assert_eq!(
        rig.commanded_counts(),
        before,
        "nothing moves before the run input"
    );
    rig.close(Contact::Run);
    assert!(
        run_until(&mut rig, "the motion starts", 20_000),
        "{:#?}",
        rig.board().log()
    );
    let rest = positions(&rig);
    assert!(
        (rest[0] - (STOP + BACK)).abs() <= 2,
        "{rest:?} {:#?}",
        rig.board().log()
    );
    assert!(
        (rest[1] - (SWITCH - BACK)).abs() <= 20,
        "{rest:?} {:#?}",
        rig.board().log()
    );
    let log = rig.board().log();
    assert!(
        log.iter()
            .any(|line| line.contains("axis 0: its reference is at -1500 counts")),
        "{log:#?}"
    );
    assert!(
        log.iter()
            .any(|line| line.contains("axis 1: its reference is at 1")),
        "{log:#?}"
    );
    // An eighth of a turn from there, half a second later.
    run_until(&mut rig, "no such line", 500);
    let away = positions(&rig);
    assert!((away[0] - rest[0] - 2_048).abs() < 100, "{away:?}");
    assert!((away[1] - rest[1] + 2_048).abs() < 100, "{away:?}");
    // Released and pressed again, without disabling: the axes are still known.
    rig.open(Contact::Run);
    assert!(run_until(&mut rig, "the motion has ended", 3_000));
    rig.close(Contact::Run);
    let lines = rig.board().log().len();
    run_until(&mut rig, "no such line", 200);
    let log = &rig.board().log()[lines..];
    assert!(
        log.iter().any(|line| line.contains("the motion starts")),
        "{log:#?}"
    );
    assert!(
        !log.iter().any(|line| line.contains("homing from")),
        "{log:#?}"
    );
}

#[test]
fn after_the_drives_were_disabled_the_axes_are_homed_again() {
    let mut rig = machine(Some(STOP), SWITCH);
    rig.close(Contact::Run);
    assert!(
        run_until(&mut rig, "the motion starts", 20_000),
        "{:#?}",
        rig.board().log()
    );
    rig.open(Contact::Run);
    rig.open(Contact::Enable);
    rig.run_ms(1_500);
    assert!(!rig.are_enabled());
    let lines = rig.board().log().len();
    rig.enable();
    rig.run_ms(100);
    rig.close(Contact::Run);
    run_until(&mut rig, "no such line", 200);
    let log = &rig.board().log()[lines..];
    assert!(
        log.iter().any(|line| line.contains("axis 0: homing from")),
        "{log:#?}"
    );
}

#[test]
fn without_its_stop_nothing_moves_after_the_search() {
    let mut rig = machine(None, SWITCH);
    rig.close(Contact::Run);
    assert!(
        run_until(
            &mut rig,
            "axis 0: nothing was found within 8192 counts",
            20_000
        ),
        "{:#?}",
        rig.board().log()
    );
    let rest = positions(&rig);
    assert!((rest[0] + 8_192).abs() <= 2 && rest[1] == 0, "{rest:?}");
    rig.run_ms(1_000);
    assert_eq!(positions(&rig), rest);
    let log = rig.board().log();
    assert!(
        !log.iter().any(|line| line.contains("the motion starts")),
        "{log:#?}"
    );
    // The operator's word is needed: enable goes off and the drives with it.
    rig.open(Contact::Enable);
    rig.run_ms(1_500);
    assert!(!rig.are_enabled());
}

#[test]
fn an_open_stop_circuit_ends_a_homing_as_everything_else() {
    let mut rig = machine(Some(STOP), SWITCH);
    rig.close(Contact::Run);
    assert!(run_until(&mut rig, "axis 0: homing from", 1_000));
    rig.run_ms(500);
    rig.open(Contact::Stop);
    rig.run_ms(20);
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_500);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    assert!(!rig.are_enabled());
}

/// The run input is released in the middle of the search: it slows down, and nothing was found.
#[test]
fn releasing_run_stops_a_homing_and_pressing_it_begins_anew() {
    let mut rig = machine(Some(STOP), SWITCH);
    rig.close(Contact::Run);
    assert!(run_until(&mut rig, "axis 0: homing from", 1_000));
    rig.run_ms(100);
    rig.open(Contact::Run);
    assert!(
        run_until(&mut rig, "its homing was stopped", 1_000),
        "{:#?}",
        rig.board().log()
    );
    let rest = positions(&rig);
    rig.run_ms(500);
    assert_eq!(positions(&rig), rest);
    assert!(rig.are_enabled());
    rig.close(Contact::Run);
    assert!(
        run_until(&mut rig, "the motion starts", 20_000),
        "{:#?}",
        rig.board().log()
    );
}
