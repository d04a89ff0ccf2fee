//! Settings and faults in the flash of the image that takes orders.

mod orders;

use board_link::Reason;
use board_link::frame::checksum;
use board_link::host::{Incoming, RequestError};
use board_link::message::{Answer, BoardState, Chunk, FaultEntry, Info, Request};
use board_settings::{Kind, LONGEST, Settings};
use dyn_can::Alarm;
use firmware_tests::flash::FlashContent;
use firmware_tests::host::Host;
use firmware_tests::records::{bytes_of, latest, settings_of};
use firmware_tests::watchdog::FASTEST_LSI_HZ;
use firmware_tests::{ResetCause, Rig, rig};
use orders::{AXES, settings, with_settings};

/// Bytes of a piece.
const PIECE: usize = 128;

fn blank_board() -> (Rig, Host) {
    let mut rig = Rig::with_numbered_drives(rig::image("link"), AXES as i32);
    let host = Host::new(&mut rig, 1);
    (rig, host)
}

/// Sends new settings as far as the board takes them: their check included.
fn stage(rig: &mut Rig, host: &mut Host, bytes: &[u8]) -> Result<Answer, RequestError> {
    for (piece, offset) in bytes.chunks(PIECE).zip((0..).step_by(PIECE)) {
        let bytes = Chunk::from_slice(piece).expect("a piece fits");
        host.ask(rig, Request::WriteSettings { offset, bytes })?;
    }
    let (length, checksum) = (bytes.len() as u32, checksum(bytes));
    host.ask(rig, Request::CheckSettings { length, checksum })
}

fn commit(bytes: &[u8]) -> Request {
    Request::CommitSettings {
        length: bytes.len() as u32,
        checksum: checksum(bytes),
    }
}

fn save(rig: &mut Rig, host: &mut Host, bytes: &[u8]) -> Result<Answer, RequestError> {
    stage(rig, host, bytes)?;
    host.ask(rig, commit(bytes))
}

fn read_settings(rig: &mut Rig, host: &mut Host) -> Vec<u8> {
    let mut all = Vec::new();
    loop {
        let offset = all.len() as u32;
        match host.ask(rig, Request::ReadSettings { offset }) {
            Ok(Answer::Settings { length, bytes, .. }) => {
                all.extend_from_slice(&bytes);
                if all.len() >= length as usize {
                    return all;
                }
            }
            other => panic!("{other:?}"),
        }
    }
}

fn info(rig: &mut Rig, host: &mut Host) -> Info {
    match host.ask(rig, Request::Hello) {
        Ok(Answer::Info(info)) => info,
        other => panic!("{other:?}"),
    }
}

fn fault(rig: &mut Rig, host: &mut Host, index: u32) -> Result<FaultEntry, RequestError> {
    host.ask(rig, Request::ReadFault { index })
        .map(|answer| match answer {
            Answer::Fault(entry) => entry,
            other => panic!("{other:?}"),
        })
}

fn content(rig: &Rig) -> FlashContent {
    rig.board().soc().flash.content().clone()
}

fn stored(rig: &Rig) -> Option<Vec<u8>> {
    latest(&mut settings_of(content(rig), rig::chip()))
}

/// The supply goes and comes back: a new host begins.
fn restart(rig: &mut Rig, seed: u64) -> Host {
    rig.cut_power(100, 20_000, seed);
    let _ = rig.received_serial();
    let mut host = Host::new(rig, seed + 10);
    host.connect(rig);
    host
}

#[test]
fn a_board_without_settings_answers_and_moves_nothing_until_it_has_some() {
    let (mut rig, mut host) = blank_board();
    rig.board_mut().soc_mut().watchdog.oscillator_hz = FASTEST_LSI_HZ;
    host.connect(&mut rig);
    let blank = info(&mut rig, &mut host);
    assert_eq!((blank.axes, blank.settings), (0, LONGEST as u32));
    assert_eq!(host.refusal(&mut rig, Request::Enable), Reason::NotReady);
    assert!(read_settings(&mut rig, &mut host).is_empty());

    let bytes = bytes_of(&settings());
    assert_eq!(save(&mut rig, &mut host, &bytes), Ok(Answer::Done));
    assert_eq!(stored(&rig), Some(bytes.clone()));
    // They count from the next start on.
    assert_eq!(info(&mut rig, &mut host).axes, 0);
    let mut host = restart(&mut rig, 1);
    assert_eq!(info(&mut rig, &mut host).axes as usize, AXES);
    assert_eq!(read_settings(&mut rig, &mut host), bytes);
    host.bring_up(&mut rig);
}

#[test]
fn seven_saves_with_their_erases_leave_the_watchdog_quiet() {
    let (mut rig, mut host) = with_settings();
    rig.board_mut().soc_mut().watchdog.oscillator_hz = FASTEST_LSI_HZ;
    // The drives start with power, and are switched off here.
    host.bring_up(&mut rig);
    assert_eq!(host.ask(&mut rig, Request::Disable), Ok(Answer::Done));
    host.run_ms(&mut rig, 500);
    let resets = rig.board().resets().len();
    for number in 0..7 {
        let named = Settings {
            name: [char::from(b'a' + number)].into_iter().collect(),
            ..settings()
        };
        let bytes = bytes_of(&named);
        let saved = save(&mut rig, &mut host, &bytes);
        assert_eq!(saved, Ok(Answer::Done), "{:#?}", rig.board().log());
        assert_eq!(stored(&rig), Some(bytes));
        host.run_ms(&mut rig, 100);
        if !host.client().is_connected() {
            host.connect(&mut rig);
        }
    }
    assert_eq!(
        rig.board().resets().len(),
        resets,
        "{:?}",
        rig.board().resets()
    );
    // The watchdog is as short as before: it still bites soon.
    let expires_ns = rig.board().soc().watchdog.expires_ns().unwrap();
    assert!(expires_ns - rig.board().soc().now_ns() < 20_000_000);
    host.bring_up(&mut rig);
}

#[test]
fn what_is_refused_changes_nothing() {
    let (mut rig, mut host) = with_settings();
    host.connect(&mut rig);
    let before = content(&rig);
    let good = bytes_of(&settings());
    let number = |result: Result<Answer, RequestError>| match result {
        Err(RequestError::Refused(refused)) => (
            refused.number,
            refused.axis,
            refused.expected,
            refused.actual,
        ),
        other => panic!("not refused: {other:?}"),
    };
    let told = |kind: Kind, expected, actual| (kind.number(), None, expected, actual);

    let mut newer = good.clone();
    newer[0] = 3;
    assert_eq!(
        number(save(&mut rig, &mut host, &newer)),
        told(Kind::Version, 2, 3)
    );
    let none = Settings {
        axes: Default::default(),
        ..settings()
    };
    let none = bytes_of(&none);
    assert_eq!(
        number(save(&mut rig, &mut host, &none)),
        told(Kind::AxisCount, 1, 0)
    );
    // Fifteen, as another program might write them.
    let count = none.len() - 1;
    let one = &good[count + 1..][..(good.len() - count - 1) / AXES];
    let mut many = good[..count].to_vec();
    many.push(15);
    many.extend(one.repeat(15));
    assert_eq!(
        number(save(&mut rig, &mut host, &many)),
        told(Kind::AxisCount, 14, 15)
    );
    let mut fast = settings();
    fast.axes[2].speed_rpm = 60_004;
    let fast = bytes_of(&fast);
    assert_eq!(
        number(save(&mut rig, &mut host, &fast)),
        (Kind::Speed.number(), Some(2), 60_003, 60_004)
    );
    // Another checksum than announced, and more than there is room for.
    stage(&mut rig, &mut host, &good).unwrap();
    let wrong = Request::CommitSettings {
        length: good.len() as u32,
        checksum: checksum(&good) ^ 1,
    };
    assert_eq!(host.refusal(&mut rig, wrong), Reason::Checksum);
    let long = vec![1; LONGEST + 1];
    let refused = number(stage(&mut rig, &mut host, &long));
    assert_eq!(
        refused,
        (
            Reason::Length.number(),
            None,
            LONGEST as i64,
            LONGEST as i64 + 1
        )
    );
    assert!(rig.board().soc().flash.history().is_empty());
    assert_eq!(content(&rig), before);
    assert_eq!(read_settings(&mut rig, &mut host), good);
}

#[test]
fn nothing_is_saved_while_a_drive_is_enabled() {
    let (mut rig, mut host) = with_settings();
    host.bring_up(&mut rig);
    let good = bytes_of(&settings());
    stage(&mut rig, &mut host, &good).unwrap();
    assert_eq!(host.refusal(&mut rig, commit(&good)), Reason::Enabled);
    assert!(rig.board().soc().flash.history().is_empty());
    assert_eq!(host.ask(&mut rig, Request::Disable), Ok(Answer::Done));
    host.run_ms(&mut rig, 500);
    assert_eq!(host.ask(&mut rig, commit(&good)), Ok(Answer::Done));
    assert!(!rig.board().soc().flash.history().is_empty());
}

/// So many cuts; each within, or just before or after, the writing of a record.
const CUTS: u64 = 200;

#[test]
fn a_cut_of_the_supply_while_settings_are_saved_leaves_the_old_or_the_new_ones() {
    let (mut rig, mut host) = with_settings();
    host.connect(&mut rig);
    let mut random = fastrand::Rng::with_seed(2_026);
    let (mut within, mut new_ones) = (0, 0);
    let mut old = bytes_of(&settings());
    for number in 0..CUTS {
        let named = Settings {
            name: format!("{number}").as_str().try_into().unwrap(),
            ..settings()
        };
        let new = bytes_of(&named);
        stage(&mut rig, &mut host, &new).unwrap();
        let is_long = settings_of(content(&rig), rig::chip()).is_full().unwrap();
        host.client().request(commit(&new)).unwrap();
        let before = rig.board().soc().flash.history().len();
        // Until the command is there, and then anywhere in the operations.
        let _ = host.run_until(&mut rig, 20, |_, rig| rig.board().soc().flash.is_changing());
        let erase_us = match (rig::chip().name, is_long) {
            (_, false) => 0,
            ("stm32f405", true) => 500_000,
            (_, true) => 49_000,
        };
        // In the erase, or at the double words of the record, or after its end.
        let us = match random.u8(0..4) {
            0 => random.u64(0..=erase_us),
            1 | 2 => erase_us + random.u64(0..6_000),
            _ => erase_us + random.u64(6_000..40_000),
        };
        rig.cut_power(us, 20_000, random.u64(..));
        let operations = rig.board().soc().flash.history().len() - before;
        within += u64::from(operations > 0 && stored(&rig).as_ref() == Some(&old));
        let context = format!("cut {number}, seed 2026, {operations} operations");
        let now = stored(&rig).unwrap_or_else(|| panic!("{context}: neither"));
        assert!(now == old || now == new, "{context}");
        new_ones += u64::from(now == new);
        let _ = rig.received_serial();
        host = Host::new(&mut rig, number + 100);
        host.connect(&mut rig);
        let read = read_settings(&mut rig, &mut host);
        assert_eq!(read, now, "{context}: {:#?}", rig.board().log());
        old = now;
    }
    let causes = rig.board().resets().iter().map(|reset| reset.cause);
    let cuts = causes.filter(|cause| *cause == ResetCause::PowerOn).count();
    println!("{cuts} cuts: {new_ones} left the new settings, {within} came before their end");
    assert!(within >= 50 && new_ones >= 50, "{within} {new_ones}");
}

#[test]
fn faults_go_to_the_flash_when_everything_is_off_and_are_there_after_a_power_cut() {
    let (mut rig, mut host) = with_settings();
    host.bring_up(&mut rig);
    let started = info(&mut rig, &mut host);
    assert_eq!(started.faults, 0);
    assert!(fault(&mut rig, &mut host, 0).is_err());
    let third = rig.drives()[2];
    rig.servo_mut(third)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    host.run_ms(&mut rig, 50);
    let logged = fault(&mut rig, &mut host, 0).unwrap();
    assert!((1..=4).contains(&info(&mut rig, &mut host).faults));
    assert_eq!(logged.boot, started.boot);
    assert_eq!(logged.firmware.as_str(), started.firmware.as_str());
    assert!(logged.uptime_ms > 0 && u64::from(logged.uptime_ms) < rig.now_ms());
    let all = info(&mut rig, &mut host).faults;
    let first = fault(&mut rig, &mut host, all - 1).unwrap();
    assert_eq!((first.axis, first.code), (Some(2), 1), "{first:?}");
    // The other drives go off, and half a second later each fault is in the flash.
    rig.open(firmware_tests::Contact::Enable);
    host.run_ms(&mut rig, 4_000);
    assert!(!rig.board().soc().flash.history().is_empty());
    println!(
        "{:#?} {:?}",
        rig.board().log(),
        rig.board().soc().flash.history().len()
    );
    let mut host = restart(&mut rig, 3);
    let after = info(&mut rig, &mut host);
    assert!(after.faults >= all, "{after:?} {:#?}", rig.board().log());
    let kept: Vec<_> = (0..after.faults)
        .map(|index| fault(&mut rig, &mut host, index).unwrap())
        .collect();
    assert!(kept.contains(&first), "{kept:?}");
    assert_eq!(after.boot, started.boot + 1);
}

#[test]
fn a_reset_by_the_watchdog_is_in_the_log_and_in_the_flash() {
    let (mut rig, mut host) = with_settings();
    host.connect(&mut rig);
    let before = info(&mut rig, &mut host);
    // The timer of the cycle stops, so nobody feeds.
    rig.board_mut().soc_mut().write(0x4000_0000, 4, 0);
    host.run_ms(&mut rig, 1_000);
    let resets: Vec<_> = rig
        .board()
        .resets()
        .iter()
        .map(|reset| reset.cause)
        .collect();
    assert_eq!(resets.last(), Some(&ResetCause::Watchdog));
    let is_lost = host.run_until(&mut rig, 2_000, |host, _| {
        host.told.contains(&Incoming::Disconnected) || host.client().is_connected()
    });
    assert!(is_lost);
    host.connect(&mut rig);
    let logged = fault(&mut rig, &mut host, 0).unwrap();
    assert_eq!((logged.code, logged.axis), (203, None), "{logged:?}");
    assert_eq!(logged.boot, before.boot);
    assert_eq!(info(&mut rig, &mut host).boot, before.boot + 1);
    assert_eq!(host.state(&mut rig), BoardState::Locked);
    host.run_ms(&mut rig, 1_500);
    let mut host = restart(&mut rig, 5);
    assert_eq!(fault(&mut rig, &mut host, 0).unwrap(), logged);
}
