//! The image that takes orders homes its axes as its settings say, against simulated stops and a switch on a pin, for a host over the serial
//! port.

mod orders;

use board_link::WhenDry;
use board_link::host::{Incoming, RequestError};
use board_link::message::{Answer, BoardState, Event, Origin, Request};
use board_link::segment::{AxisSegment, Begin, Segment, Shape, StreamPhase};
use board_link::{Reason, Refused};
use board_settings::{
    HomingDirection, HomingMethod, HomingSearch, HomingSettings, Settings, SwitchLevel, Travel,
};
use drive_sim::{DynDriveConfig, EndStops, Mechanics, Switch, SwitchSide};
use dyn_can::Alarm;
use firmware_tests::host::Host;
use firmware_tests::records::{bytes_of, settings_of};
use firmware_tests::{Contact, Rig, rig};
use orders::{Judge, counts_told, targets};
use trajectory::Time;

/// Where the stops and the switch are, in counts from where the shafts stand at power-on.
const LOW: i64 = -1_500;
const HIGH: i64 = 1_700;
const SWITCH: i64 = 1_200;
/// 9 degrees.
const BACK: i64 = 409;
/// Half a turn.
const WAY: i64 = 8_192;
/// How far the axes may go from their origins: a turn and a half.
const TRAVEL: i32 = 24_576;
/// The longest homing of these machines.
const MOST_MS: u64 = 30_000;
/// From an end in the middle to rest.
const REST_MS: u64 = 1_500;

fn search(direction: HomingDirection) -> HomingSearch {
    HomingSearch {
        speed_rpm: 20,
        slow_speed_rpm: 6,
        acceleration_rpm_per_s: 1_000,
        back_off_millidegrees: 9_000,
        ..HomingSearch::new(direction, 180_000)
    }
}

fn stop(direction: HomingDirection) -> HomingSettings {
    HomingSettings::stop(search(direction))
}

/// Four axes: to a low stop, to a high one, to a switch, and here at a quarter of a turn. The switch comes first.
fn settings() -> Settings {
    let mut settings = orders::settings();
    for axis in &mut settings.axes {
        axis.polls.torque_us = 20_000;
        axis.travel = Travel::Counts {
            min: -TRAVEL,
            max: TRAVEL,
        };
    }
    settings.axes[0].homing = Some(HomingSettings {
        order: 1,
        ..stop(HomingDirection::Negative)
    });
    settings.axes[1].homing = Some(HomingSettings {
        order: 1,
        ..stop(HomingDirection::Positive)
    });
    settings.axes[2].homing = Some(HomingSettings::new(HomingMethod::Switch {
        search: search(HomingDirection::Positive),
        pin: 3,
        active: SwitchLevel::High,
    }));
    settings.axes[3].homing = Some(HomingSettings {
        order: 2,
        reference_millidegrees: 90_000,
        ..HomingSettings::new(HomingMethod::Here)
    });
    settings
}

/// The first axis alone is homed, the others may go where they want.
fn first_axis() -> Settings {
    let mut settings = settings();
    for axis in settings.axes.iter_mut().skip(1) {
        axis.homing = None;
    }
    settings
}

/// A board with these settings in its flash, its drives between stops if there are such.
fn board(image: &str, settings: &Settings, has_stops: bool) -> (Rig, Host) {
    let config = |id| {
        let stops = EndStops {
            low_counts: LOW,
            high_counts: HIGH,
        };
        let switch = Switch {
            at_counts: SWITCH,
            side: SwitchSide::Above,
        };
        DynDriveConfig {
            mechanics: Mechanics {
                stops: (has_stops && id < 3).then_some(stops),
                switch: (id == 3).then_some(switch),
            },
            ..DynDriveConfig::numbered(id).expect("an id is 1 to 63")
        }
    };
    let mut rig = Rig::with_drives(rig::image(image), (1..=orders::AXES as i32).map(config));
    let content = rig.board().soc().flash.content().clone();
    let mut records = settings_of(content, rig::chip());
    records.append(&bytes_of(settings)).unwrap();
    let content = records.flash().content();
    rig.board_mut().set_flash_content(content);
    let host = Host::new(&mut rig, 1);
    (rig, host)
}

fn enabled(settings: &Settings, has_stops: bool) -> (Rig, Host) {
    let (mut rig, mut host) = board("link-homing", settings, has_stops);
    host.bring_up(&mut rig);
    (rig, host)
}

/// The switch of drive 3 on its pin.
fn connect_switch(rig: &mut Rig) {
    let now_ns = rig.board().soc().now_ns();
    let switch = rig.servos().nth(2).expect("drive 3");
    if switch.switch_is_operated(now_ns) {
        rig.close(Contact::Homing);
    } else {
        rig.open(Contact::Homing);
    }
}

/// The reply to a ticket, where it has come.
fn reply(host: &Host, ticket: u16) -> Option<Result<Answer, RequestError>> {
    host.told.iter().find_map(|told| match told {
        Incoming::Reply { ticket: of, result } if *of == ticket => Some(result.clone()),
        _ => None,
    })
}

/// Waits for the reply to a homing that was begun.
fn await_home(rig: &mut Rig, host: &mut Host, ticket: u16) -> Result<(), Refused> {
    let mut found = None;
    host.run_until(rig, MOST_MS, |host, rig| {
        connect_switch(rig);
        found = reply(host, ticket);
        found.is_some()
    });
    match found {
        Some(Ok(Answer::Done)) => Ok(()),
        Some(Err(RequestError::Refused(refused))) => Err(refused),
        other => panic!("{other:?} {:#?}", rig.board().log()),
    }
}

fn home(rig: &mut Rig, host: &mut Host) -> Result<(), Refused> {
    let ticket = host.client().request(Request::Home).expect("it is free");
    await_home(rig, host, ticket)
}

fn positions(rig: &Rig) -> Vec<i64> {
    let now_ns = rig.board().soc().now_ns();
    rig.servos()
        .map(|drive| drive.position_counts(now_ns))
        .collect()
}

fn origins(rig: &mut Rig, host: &mut Host) -> Vec<Origin> {
    (0..orders::AXES as u8)
        .map(|axis| match host.ask(rig, Request::ReadOrigin { axis }) {
            Ok(Answer::Origin(origin)) => origin,
            other => panic!("{other:?}"),
        })
        .collect()
}

fn begin_here(stream: u32, host: &Host) -> Request {
    let from = targets(host).into_iter();
    Request::Begin(Begin {
        stream,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: from.map(|target| i64::from(target) << 24).collect(),
    })
}

/// Three seconds to these counts of the drives.
fn segment_to(counts: &[i32]) -> Segment {
    Segment {
        duration: Time::from_cycles(3_000).ticks(),
        axes: counts
            .iter()
            .map(|counts| AxisSegment {
                end: i64::from(*counts) << 24,
                shape: Shape::MinimumJerk,
            })
            .collect(),
    }
}

fn is_near(actual: i64, expected: i64, by: i64) -> bool {
    (actual - expected).abs() <= by
}

#[test]
fn each_method_finds_its_origin_and_what_is_streamed_keeps_the_travel_from_there() {
    let (mut rig, mut host) = enabled(&settings(), true);
    assert_eq!(origins(&mut rig, &mut host), [Origin::Unknown; 4]);
    host.look_at_machine(&mut rig);
    let begin = begin_here(1, &host);
    assert_eq!(
        host.ask(&mut rig, begin),
        Err(RequestError::Refused(Reason::NotHomed.at(0, 0, 0)))
    );
    let ticket = host.client().request(Request::Home).unwrap();
    let begins_ns = rig.board().soc().now_ns();
    host.run_until(&mut rig, 600, |_, rig| {
        connect_switch(rig);
        false
    });
    assert_eq!(host.snapshot.state, BoardState::Homing);
    // One after the other: the switch is the first.
    let told = counts_told(&rig, begins_ns);
    let moves: Vec<bool> = told
        .iter()
        .map(|told| told.iter().any(|counts| *counts != 0))
        .collect();
    assert_eq!(moves, [false, false, true, false]);
    assert_eq!(await_home(&mut rig, &mut host, ticket), Ok(()));
    let found = origins(&mut rig, &mut host);
    let counts: Vec<i64> = found
        .iter()
        .map(|origin| origin.counts().expect("it is known").into())
        .collect();
    let log = rig.board().log().to_vec();
    assert!(is_near(counts[0], LOW, 2), "{counts:?} {log:#?}");
    assert!(is_near(counts[1], HIGH, 2), "{counts:?} {log:#?}");
    assert!(is_near(counts[2], SWITCH, 20), "{counts:?} {log:#?}");
    // It stands at a quarter of a turn of its axis.
    assert_eq!(counts[3], -4_096);
    let rests = positions(&rig);
    assert!(is_near(rests[0], LOW + BACK, 2), "{rests:?}");
    assert!(is_near(rests[1], HIGH - BACK, 2), "{rests:?}");
    assert!(is_near(rests[2], counts[2] - BACK, 2), "{rests:?}");
    assert_eq!(rests[3], 0);
    let homed: Vec<(u8, i32)> = host
        .told
        .iter()
        .filter_map(|told| match told {
            Incoming::Event {
                event: Event::Homed { axis, counts, .. },
                ..
            } => Some((*axis, *counts)),
            _ => None,
        })
        .collect();
    let expected = [2, 0, 1, 3].map(|axis| (axis as u8, counts[axis] as i32));
    assert_eq!(homed, expected);
    assert_eq!(host.state(&mut rig), BoardState::Enabled);
    assert!(rig.are_enabled());
    // To the high end of the travel of the first axis and no count farther, from its origin.
    let end = counts[0] as i32 + TRAVEL;
    let mut places = targets(&host);
    places[0] = end + 1;
    let begin = begin_here(2, &host);
    assert_eq!(host.ask(&mut rig, begin), Ok(Answer::Done));
    let segment = Request::Segment {
        stream: 2,
        index: 0,
        segment: segment_to(&places),
    };
    let beyond = Reason::Travel.at(0, i64::from(end) << 24, i64::from(end + 1) << 24);
    assert_eq!(
        host.ask(&mut rig, segment),
        Err(RequestError::Refused(beyond))
    );
    assert_eq!(host.ask(&mut rig, Request::Stop), Ok(Answer::Done));
    host.run_ms(&mut rig, 100);
    // The stops are only on the way of the shafts: this one goes the other way than its stop.
    places[0] = end;
    places[1] = counts[1] as i32 - TRAVEL;
    places[2] = counts[2] as i32 - TRAVEL;
    places[3] = counts[3] as i32 + TRAVEL;
    let ways: Vec<i64> = places
        .iter()
        .zip(targets(&host))
        .map(|(to, from)| i64::from(to - from))
        .collect();
    // The low stop bounds the second one, and the high stop the first.
    let bounded = [HIGH - 100, LOW + 100];
    places[0] = bounded[0] as i32;
    places[1] = bounded[1] as i32;
    assert!(ways.iter().all(|way| *way != 0));
    host.stream(&mut rig, 3, vec![segment_to(&places)], WhenDry::End);
    let is_complete = host.run_until(&mut rig, 6_000, |host, _| {
        host.phases(3).contains(&StreamPhase::Complete)
    });
    assert!(is_complete, "{:?} {:#?}", host.told, rig.board().log());
    host.run_ms(&mut rig, 300);
    let there: Vec<i64> = places.iter().map(|place| i64::from(*place)).collect();
    let actual = positions(&rig);
    let near = actual.iter().zip(&there);
    assert!(near.clone().all(|(a, b)| is_near(*a, *b, 2)), "{actual:?}");
    host.run_ms(&mut rig, 1_000);
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
}

/// A stream under way is no homing, and the other way round.
#[test]
fn a_homing_waits_for_no_stream_and_is_refused_with_the_reason_where_it_cannot_be() {
    let (mut rig, mut host) = board("link-homing", &first_axis(), true);
    rig.make_ready();
    rig.close(Contact::Enable);
    host.run_ms(&mut rig, 50);
    host.connect(&mut rig);
    let from_ns = rig.board().soc().now_ns();
    let refused = |result| match result {
        Err(RequestError::Refused(refused)) => refused,
        other => panic!("{other:?}"),
    };
    let off = refused(host.ask(&mut rig, Request::Home));
    let enabled = BoardState::Enabled as i64;
    assert_eq!(
        off,
        Reason::NotEnabled.because(enabled, BoardState::Off as i64)
    );
    for (contact, reason) in [
        (Contact::Enable, Reason::EnableInput),
        (Contact::Stop, Reason::StopInput),
    ] {
        rig.open(contact);
        host.run_ms(&mut rig, 700);
        assert_eq!(
            refused(host.ask(&mut rig, Request::Home)),
            reason.plain(),
            "{contact:?}"
        );
    }
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    // Homed, and moving.
    rig.close(Contact::Stop);
    rig.close(Contact::Enable);
    host.run_ms(&mut rig, 1_000);
    host.bring_up(&mut rig);
    assert_eq!(home(&mut rig, &mut host), Ok(()));
    host.look_at_machine(&mut rig);
    let mut places = targets(&host);
    places[3] += 20_000;
    host.stream(&mut rig, 4, vec![segment_to(&places)], WhenDry::End);
    host.run_ms(&mut rig, 1_000);
    assert_eq!(
        refused(host.ask(&mut rig, Request::Home)),
        Reason::Moving.because(4, 0)
    );
    let is_complete = host.run_until(&mut rig, 6_000, |host, _| {
        host.phases(4).contains(&StreamPhase::Complete)
    });
    assert!(is_complete);
    // And again, as often as one wants.
    assert_eq!(home(&mut rig, &mut host), Ok(()));
}

/// What ends a homing in its middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ends {
    Stop,
    Release,
    Dies,
    Halt,
    Disable,
    StopInput,
    EnableInput,
    Alarm,
}

const ALL: [Ends; 8] = [
    Ends::Stop,
    Ends::Release,
    Ends::Dies,
    Ends::Halt,
    Ends::Disable,
    Ends::StopInput,
    Ends::EnableInput,
    Ends::Alarm,
];

#[test]
fn whatever_ends_a_homing_brings_the_axes_to_rest_and_the_answer_says_what_it_was() {
    for ends in ALL {
        let (mut rig, mut host) = enabled(&first_axis(), true);
        let judge = Judge::from_now(&rig);
        let ticket = host.client().request(Request::Home).unwrap();
        // At full speed on its way.
        host.run_ms(&mut rig, 450);
        assert!(judge.is_moving(&rig), "{ends:?}");
        let before = positions(&rig)[0];
        assert!(before > LOW + 200, "{ends:?}: it is at its stop already");
        let asked_ns = rig.board().soc().now_ns();
        match ends {
            Ends::Stop => drop(host.client().request(Request::Stop)),
            Ends::Halt => drop(host.client().request(Request::Halt)),
            Ends::Dies => host.is_dead = true,
            Ends::StopInput => rig.open(Contact::Stop),
            Ends::EnableInput => rig.open(Contact::Enable),
            Ends::Alarm => {
                let drive = rig.drives()[0];
                let faults = rig.servo_mut(drive).faults_mut();
                faults.raise_alarm(Alarm::OverCurrent);
            }
            // The client has one request at a time; another program at the port has not.
            Ends::Release | Ends::Disable => {
                let request = match ends {
                    Ends::Release => Request::Release,
                    _ => Request::Disable,
                };
                let session = host.client().session();
                send(&mut rig, session, request);
            }
        }
        host.run_ms(&mut rig, REST_MS);
        assert!(!judge.is_moving(&rig), "{ends:?}");
        let rest = positions(&rig)[0];
        let told = counts_told(&rig, asked_ns);
        let is_ramp = matches!(
            ends,
            Ends::Stop | Ends::Release | Ends::Dies | Ends::Disable | Ends::EnableInput
        );
        if is_ramp {
            // Slower in each cycle, by what the search or the axis may: no step of the speed ends it.
            let steps: Vec<i32> = told[0].windows(2).map(|two| two[1] - two[0]).collect();
            let pairs = steps.windows(2);
            let steepest = pairs.map(|two| (two[1] - two[0]).abs()).max();
            assert!(steepest <= Some(3), "{ends:?} {steps:?}");
            // The search has a slow ramp; the master has that of the axis, a few cycles from this speed.
            let by_search = matches!(ends, Ends::Stop | Ends::Release | Ends::Dies);
            assert!(!by_search || steps.len() > 10, "{ends:?} {steps:?}");
        }
        assert!(is_near(rest, before, 900), "{ends:?}: {before} {rest}");
        host.is_dead = false;
        let stays_on = matches!(ends, Ends::Stop | Ends::Release | Ends::Dies | Ends::Halt);
        // Of the drives whose motors have no alarm the others hold.
        if ends != Ends::Alarm {
            assert_eq!(rig.are_enabled(), stays_on, "{ends:?}");
        }
        // Who has given the command back has no connection any more to which an answer could come.
        if !matches!(ends, Ends::Dies | Ends::Release) {
            let result = match reply(&host, ticket) {
                Some(Err(RequestError::Refused(refused))) => refused,
                other => panic!("{ends:?}: {other:?} {:#?}", rig.board().log()),
            };
            let expected = match ends {
                Ends::StopInput => Reason::StopInput,
                Ends::EnableInput => Reason::EnableInput,
                Ends::Alarm => Reason::Faulted,
                _ => Reason::HomeStopped,
            };
            assert_eq!(result.reason(), Some(expected), "{ends:?}");
            assert_eq!(result.axis, Some(0), "{ends:?}");
        }
        // Nothing of it goes on, whatever comes back.
        rig.close(Contact::Stop);
        rig.close(Contact::Enable);
        let closed_ns = rig.board().soc().now_ns();
        host.run_ms(&mut rig, 1_500);
        let told = counts_told(&rig, closed_ns);
        assert!(told.iter().flatten().all(|counts| *counts == 0), "{ends:?}");
        host.connect(&mut rig);
        assert_eq!(origins(&mut rig, &mut host)[0], Origin::Unknown, "{ends:?}");
        if stays_on && ends != Ends::Halt {
            host.look_at_machine(&mut rig);
            let begin = begin_here(8, &host);
            assert_eq!(host.refusal(&mut rig, begin), Reason::NotHomed, "{ends:?}");
            // Another one finds it.
            assert_eq!(home(&mut rig, &mut host), Ok(()), "{ends:?}");
        }
    }
}

/// A message that no client keeps account of.
fn send(rig: &mut Rig, session: u32, request: Request) {
    let message = board_link::message::ToBoard {
        number: 60_000,
        session,
        request,
    };
    let mut bytes = [0; 64];
    let length = board_link::frame::encode(&message, &mut bytes).expect("room");
    rig.send_serial(&[0]);
    rig.send_serial(&bytes[..length]);
}

#[test]
fn what_is_not_found_is_said_and_the_axis_stays_where_its_way_ends() {
    let (mut rig, mut host) = enabled(&first_axis(), false);
    let refused = home(&mut rig, &mut host).unwrap_err();
    assert_eq!(refused, Reason::HomeNotFound.at(0, WAY, WAY));
    let rest = positions(&rig)[0];
    assert!(is_near(rest, -WAY, 2), "{rest}");
    host.run_ms(&mut rig, 500);
    assert_eq!(positions(&rig)[0], rest);
    assert!(rig.are_enabled());
    assert_eq!(host.state(&mut rig), BoardState::Enabled);
    let begin = begin_here(1, &host);
    assert_eq!(host.refusal(&mut rig, begin), Reason::NotHomed);
}

#[test]
fn what_is_known_is_forgotten_when_the_axes_do_not_follow_any_more() {
    let (mut rig, mut host) = enabled(&first_axis(), true);
    assert_eq!(home(&mut rig, &mut host), Ok(()));
    let found = origins(&mut rig, &mut host);
    assert!(matches!(found[0], Origin::Found { .. }));
    assert_eq!(found[1..], [Origin::OfDrive; 3]);
    assert_eq!(host.ask(&mut rig, Request::Disable), Ok(Answer::Done));
    host.run_ms(&mut rig, 1_000);
    assert_eq!(origins(&mut rig, &mut host)[0], Origin::Unknown);
    assert_eq!(host.ask(&mut rig, Request::Enable), Ok(Answer::Done));
    host.look_at_machine(&mut rig);
    let begin = begin_here(1, &host);
    assert_eq!(host.refusal(&mut rig, begin), Reason::NotHomed);
    assert_eq!(home(&mut rig, &mut host), Ok(()));
}

/// What a board has stored before there were homings.
#[test]
fn settings_without_a_homing_are_what_they_were() {
    let settings = orders::settings();
    let bytes = bytes_of(&settings);
    assert_eq!(bytes[0], 1);
    let (mut rig, mut host) = board("link-homing", &settings, true);
    host.bring_up(&mut rig);
    assert_eq!(host.refusal(&mut rig, Request::Home), Reason::NoHoming);
    assert_eq!(origins(&mut rig, &mut host), [Origin::OfDrive; 4]);
    let mut places = targets(&host);
    places[3] += 20_000;
    host.stream(&mut rig, 4, vec![segment_to(&places)], WhenDry::End);
    let is_complete = host.run_until(&mut rig, 6_000, |host, _| {
        host.phases(4).contains(&StreamPhase::Complete)
    });
    assert!(is_complete);
}

/// It neither moves with settings that it understands by half, nor loses them.
#[test]
fn an_image_without_homing_refuses_settings_that_ask_for_it() {
    let (mut rig, mut host) = board("link", &settings(), true);
    host.connect(&mut rig);
    assert_eq!(host.state(&mut rig), BoardState::NoSettings);
    assert!(
        rig.has_logged("the settings are refused, 1030"),
        "{:#?}",
        rig.board().log()
    );
    let (mut rig, mut host) = board("link", &orders::settings(), true);
    host.connect(&mut rig);
    match host.write_settings(&mut rig, &settings()) {
        Err(RequestError::Refused(refused)) => assert_eq!(refused.number, 1_030),
        other => panic!("{other:?}"),
    }
    assert_eq!(
        host.refusal(&mut rig, Request::ReadOrigin { axis: 0 }),
        Reason::Unsupported
    );
}
