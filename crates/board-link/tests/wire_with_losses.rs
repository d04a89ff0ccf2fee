//! Both ends over a wire that delays up to 50 ms, loses and damages bytes, with resets of either end.

mod bench;

use bench::{TestClient, World, segments};
use board_link::WhenDry;
use board_link::host::{Incoming, StreamEnd};
use board_link::message::{Answer, Event, Request};
use board_link::segment::StreamPhase;

/// Streams until the board has all of it and the motion is complete, from wherever the axes stand.
fn stream_to(world: &mut World, stream: u32, counts: i32, count: u32) {
    let from = world.bench.mock().targets;
    world.begin_here(stream, WhenDry::Wait);
    let mut source = segments(count, from, counts - from[0]).into_iter();
    world.until("the end of the stream", |world| {
        world.client.feed(&mut source);
        !world.bench.player.phase().is_active()
            && world
                .told
                .iter()
                .any(|told| matches!(told, Incoming::Stream(_)))
    });
}

#[test]
fn every_segment_arrives_once_and_the_sums_are_exact() {
    let mut damage = 0;
    let mut repeated = 0;
    for seed in 0..60 {
        let one_damaged_of = [0, 3_000, 700][seed as usize % 3];
        let mut world = World::new(seed, seed % 51, one_damaged_of);
        world.connect_and_enable();
        stream_to(&mut world, 5, 8_000, 100);
        assert!(
            world
                .told
                .contains(&Incoming::Stream(StreamEnd::Sent { segments: 100 })),
            "seed {seed}: {:?}",
            world.told
        );
        let Answer::Counters(counters) = world.request(Request::ReadCounters).unwrap() else {
            panic!("seed {seed}");
        };
        let player = world.bench.board.snapshot(0).player;
        assert_eq!(
            (player.phase, player.finished),
            (StreamPhase::Complete, 100),
            "seed {seed}"
        );
        assert_eq!(world.bench.mock().targets, [8_000, -4_000], "seed {seed}");
        assert_eq!(counters.segments, 100, "seed {seed}");
        world.bench.check_limits();
        let losses = counters.losses;
        damage += losses.checksum + losses.stuffing + losses.length;
        repeated += counters.repeated;
        // Without damage nothing is lost and nothing is repeated.
        assert!(
            one_damaged_of > 0 || (losses == Default::default() && counters.repeated == 0),
            "seed {seed}: {counters:?}"
        );
    }
    assert!(damage > 300 && repeated > 10, "{damage} {repeated}");
}

/// A board without a supply forgets starts in which nothing happened: their number comes again.
#[test]
fn a_board_that_lost_its_supply_is_told_as_reset_although_its_start_has_the_same_number() {
    for ran_ms in [300, 5_000, 200_000] {
        let mut world = World::new(1, 5, 0);
        world.until("a connection", |world| world.client.is_connected());
        for _ in 0..ran_ms {
            world.step();
        }
        world.told.clear();
        // Away for a while, and back without a reset.
        world.is_dead = true;
        for _ in 0..3_000 {
            world.step();
        }
        world.is_dead = false;
        world.until("it is back", |world| {
            world
                .told
                .contains(&Incoming::Connected { is_reset: false })
        });
        world.told.clear();
        let boot = world.bench.mock().boot;
        world.bench.reset();
        world.bench.mock().boot = boot;
        world.until("a new start", |world| {
            world.told.contains(&Incoming::Connected { is_reset: true })
        });
    }
}

#[test]
fn a_reset_of_the_board_ends_the_session_and_nothing_of_it_counts() {
    for seed in 0..20 {
        let mut world = World::new(seed, 5 + seed % 45, 5_000);
        world.connect_and_enable();
        world.begin_here(5, WhenDry::Wait);
        let mut source = segments(100, [0, 0], 8_000).into_iter();
        world.until("motion", |world| {
            world.client.feed(&mut source);
            world.bench.moved > 300 + 10 * seed
        });
        world.bench.reset();
        world.told.clear();
        let before = world.bench.mock().targets;
        world.until("a new connection", |world| {
            world.client.feed(&mut source);
            world.told.contains(&Incoming::Connected { is_reset: true })
        });
        assert!(
            world.told.contains(&Incoming::Stream(StreamEnd::Lost)),
            "{:?}",
            world.told
        );
        assert!(world.told.contains(&Incoming::Disconnected));
        assert_eq!(
            (world.bench.mock().targets, world.bench.moved),
            (before, 0),
            "seed {seed}"
        );
        assert!(world.bench.mock().ordered.is_empty());
        // The program begins anew, from where the axes stand.
        world.request(Request::Enable).unwrap();
        world.told.clear();
        stream_to(&mut world, 6, 8_000, 100);
        assert_eq!(
            world.bench.mock().targets[0],
            8_000,
            "seed {seed}: {:?}",
            world.told
        );
        world.bench.check_limits();
    }
}

#[test]
fn a_host_that_dies_in_motion_gives_a_ramp_and_its_successor_goes_on() {
    for seed in 0..20 {
        let mut world = World::new(seed, 5 + seed % 45, 5_000);
        world.connect_and_enable();
        world.begin_here(
            5,
            if seed % 2 == 0 {
                WhenDry::Wait
            } else {
                WhenDry::End
            },
        );
        let mut source = segments(400, [0, 0], 30_000).into_iter();
        world.until("motion", |world| {
            world.client.feed(&mut source);
            world.bench.moved > 2_000
        });
        world.is_dead = true;
        world.until("rest", |world| !world.bench.player.phase().is_active());
        let targets = world.bench.mock().targets;
        assert!(targets[0] > 2_000 && targets[0] < 30_000, "{targets:?}");
        assert!(
            (targets[0] + 2 * targets[1]).abs() <= 2,
            "on the path: {targets:?}"
        );
        world.bench.check_limits();
        world.until("the end of the session", |world| {
            world.bench.board.session().is_none()
        });
        for _ in 0..1_000 {
            world.step();
        }
        assert_eq!(world.bench.mock().targets, targets);
        // A program that is started again.
        world.client = TestClient::new(World::config(), 77_777 + seed as u32);
        world.is_dead = false;
        world.told.clear();
        world.until("a connection", |world| world.client.is_connected());
        stream_to(&mut world, 5, -3_000, 100);
        assert_eq!(world.bench.mock().targets[0], -3_000, "seed {seed}");
        world.bench.check_limits();
    }
}

#[test]
fn a_silent_host_is_a_stop_even_when_all_is_buffered() {
    let mut world = World::new(3, 2, 0);
    world.connect_and_enable();
    world.begin_here(5, WhenDry::End);
    // Two seconds, in 20 segments of 100 ms.
    let mut parts = segments(20, [0, 0], 20_000);
    for part in &mut parts {
        part.duration *= 5;
    }
    let mut source = parts.into_iter();
    world.until("the end", |world| {
        world.client.feed(&mut source);
        world
            .told
            .contains(&Incoming::Stream(StreamEnd::Sent { segments: 20 }))
    });
    world.is_dead = true;
    world.until("rest", |world| !world.bench.player.phase().is_active());
    assert_eq!(world.bench.player.phase(), StreamPhase::Stopped);
    assert!(world.bench.mock().targets[0] < 20_000);
    world.bench.check_limits();
    // Whoever comes later can read it.
    world.client = TestClient::new(World::config(), 9);
    world.is_dead = false;
    world.until("a connection", |world| world.client.is_connected());
    world.told.clear();
    world.request(Request::Events { from: 0 }).unwrap();
    for _ in 0..20 {
        world.step();
    }
    let Answer::Counters(counters) = world.request(Request::ReadCounters).unwrap() else {
        panic!()
    };
    assert_eq!(counters.silent_hosts, 1);
}

#[test]
fn no_event_is_lost_without_a_count() {
    for seed in 0..20 {
        let mut world = World::new(seed, 20, 400);
        world.connect_and_enable();
        for code in 0..200 {
            world.bench.mock().events.push_back(Event::Fault {
                axis: Some(1),
                code,
                detail: -1,
            });
            for _ in 0..(code * 7) % 40 {
                world.step();
            }
        }
        for _ in 0..5_000 {
            world.step();
        }
        let (mut next, mut lost, mut codes) = (None, 0, Vec::new());
        for told in &world.told {
            match told {
                Incoming::Event { number, event } => {
                    assert!(
                        next.is_none_or(|next| next == *number),
                        "seed {seed}: {number} after {next:?}"
                    );
                    next = Some(number + 1);
                    if let Event::Fault { code, .. } = event {
                        codes.push(*code);
                    }
                }
                Incoming::EventsLost(count) => {
                    lost += count;
                    next = next.map(|next| next + count);
                }
                _ => {}
            }
        }
        assert_eq!(codes.len() as u32 + lost, 200, "seed {seed}: {lost} lost");
        assert!(
            codes.is_sorted() && codes.len() > 150,
            "seed {seed}: {}",
            codes.len()
        );
    }
}

#[test]
fn the_clock_of_the_board_is_known_within_what_is_said() {
    for seed in 0..20 {
        let mut world = World::new(seed, 50, 0);
        world.until("a connection", |world| world.client.is_connected());
        world.until("round trips", |world| world.client.clock().rounds() >= 8);
        let clock = world.client.clock();
        let expected = world.bench.now;
        let actual = clock.cycle_at(world.now_us()).unwrap();
        let error_us = clock.error_us().unwrap();
        let off_us = 1_000 * actual.abs_diff(expected);
        // The cycle in which a step falls is known to one.
        assert!(
            off_us <= error_us + 1_000,
            "seed {seed}: {off_us} of {error_us}"
        );
        assert!(error_us < 50_000);
    }
}
