//! Two hub motors that are homed before they move: one to a hard stop, one to a switch on a pin of the board.

use drive_sim::{ZlacDrive, ZlacDriveConfig, ZlacMechanics};
use firmware_tests::{Contact, Rig, rig};
use zlac8030l::NodeId;

/// Where the stop and the switch are, in counts from where the shafts stand at power-on, and in turns.
const STOP: i64 = -1_024;
const STOP_TURNS: f64 = -0.25;
const SWITCH: i64 = 819;
const SWITCH_TURNS: f64 = 0.2;
/// How far the axes back off.
const BACK: i64 = 200;

fn machine(with_stop: bool) -> Rig {
    let config = |node, mechanics| ZlacDriveConfig {
        mechanics,
        ..ZlacDriveConfig::new(NodeId::new(node).unwrap())
    };
    let first = ZlacMechanics {
        stops_turns: with_stop.then_some((STOP_TURNS, 10.0)),
        ..ZlacMechanics::FREE
    };
    let second = ZlacMechanics {
        switch_turns: Some(SWITCH_TURNS),
        ..ZlacMechanics::FREE
    };
    let drives = [config(1, first), config(2, second)];
    let mut rig = Rig::with_hub_motors(rig::image("hub-homing"), drives);
    rig.close(Contact::Stop);
    rig.run_ms(3_000);
    rig.close(Contact::Enable);
    rig.run_ms(1_000);
    assert!(
        rig.hub_motors().all(ZlacDrive::is_enabled),
        "{:#?}",
        rig.board().log()
    );
    rig
}

/// Runs with the switch of node 2 on its pin, until the log has this text; false when it has not after so long.
fn run_until(rig: &mut Rig, text: &str, most_ms: u64) -> bool {
    for _ in 0..most_ms {
        let now_ns = rig.board().soc().now_ns();
        let second = rig.hub_motors().nth(1).expect("node 2");
        if second.switch_is_operated(now_ns) {
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
    rig.hub_motors()
        .map(|drive| drive.position_counts(now_ns))
        .collect()
}

#[test]
fn hub_motors_are_homed_one_after_the_other_and_then_they_move() {
    let mut rig = machine(true);
    rig.run_ms(300);
    assert_eq!(
        positions(&rig),
        [0, 0],
        "nothing moves before the run input"
    );
    rig.close(Contact::Run);
    assert!(
        run_until(&mut rig, "the motion starts", 30_000),
        "{:#?}",
        rig.board().log()
    );
    let rest = positions(&rig);
    let log = rig.board().log();
    assert!((rest[0] - (STOP + BACK)).abs() <= 4, "{rest:?} {log:#?}");
    assert!((rest[1] - (SWITCH - BACK)).abs() <= 40, "{rest:?} {log:#?}");
    let is_found = |line: &String| line.contains("axis 0: its reference is at -102");
    assert!(log.iter().any(is_found), "{log:#?}");
    run_until(&mut rig, "no such line", 1_000);
    let away = positions(&rig);
    assert!((away[0] - rest[0] - 512).abs() < 100, "{away:?}");
    assert!((away[1] - rest[1] + 512).abs() < 100, "{away:?}");
}

#[test]
fn without_its_stop_nothing_moves_after_the_search() {
    let mut rig = machine(false);
    rig.close(Contact::Run);
    assert!(
        run_until(&mut rig, "nothing was found within 2048 counts", 20_000),
        "{:#?}",
        rig.board().log()
    );
    rig.run_ms(500);
    let before = positions(&rig);
    rig.run_ms(1_000);
    assert_eq!(positions(&rig), before);
    let log = rig.board().log();
    assert!(
        !log.iter().any(|line| line.contains("the motion starts")),
        "{log:#?}"
    );
}
