//! The books are exact, whatever happens.

use proptest::prelude::*;

use super::*;

/// What may happen to a drive.
#[derive(Debug, Clone)]
enum Event {
    Step(i16),
    WrongStep([u8; 2]),
    Switch(bool),
    MoveBy(i16),
    Origin,
    Alarm,
    Reset,
    Misconfigure(u8),
    Reboot { off_ns: u64 },
    Leave(bool),
    Wait { ns: u64 },
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        20 => (-200..=200_i16).prop_map(Event::Step),
        2 => (-16_384..=16_384_i16).prop_map(Event::Step),
        1 => prop_oneof![Just([0x40, 0x01]), Just([0xBF, 0xFF])].prop_map(Event::WrongStep),
        2 => any::<bool>().prop_map(Event::Switch),
        1 => any::<i16>().prop_map(Event::MoveBy),
        1 => Just(Event::Origin),
        1 => Just(Event::Alarm),
        1 => Just(Event::Reset),
        1 => prop_oneof![Just(0), 0..=0xFF_u8].prop_map(Event::Misconfigure),
        1 => (0..5 * MS).prop_map(|off_ns| Event::Reboot { off_ns }),
        1 => any::<bool>().prop_map(Event::Leave),
        10 => (0..3 * MS).prop_map(|ns| Event::Wait { ns }),
    ]
}

/// What must be in the books, kept by looking only at what the drive shows before each step.
fn accepts(probe: &Probe, is_gone: bool) -> bool {
    let config = probe.drive.config_byte().to_byte();
    let is_position_over_link = config & 0b0001_1011 == 0;
    !is_gone
        && probe.drive.is_ready()
        && probe.drive.alarm() == Alarm::None
        && probe.drive.is_enabled()
        && is_position_over_link
}

fn play(probe: &mut Probe, event: &Event) {
    match event {
        Event::Step(step) => probe.hear(0x03C, &step.to_be_bytes()),
        Event::WrongStep(data) => probe.hear(0x03C, data),
        Event::Switch(on) => probe.hear(0x039, &[if *on { 0x00 } else { 0xFF }]),
        Event::MoveBy(distance) => probe.hear(0x023, &distance.to_be_bytes()),
        Event::Origin => probe.hear(0x020, &[0xAB]),
        Event::Alarm => probe.drive.faults_mut().raise_alarm(Alarm::OverCurrent),
        Event::Reset => probe.hear(0x03B, &[0xFE]),
        Event::Misconfigure(byte) => probe
            .drive
            .faults_mut()
            .misconfigure(ConfigByte::from_byte(*byte)),
        Event::Reboot { off_ns } => probe.drive.faults_mut().power_cycle(*off_ns),
        Event::Leave(true) => probe.drive.faults_mut().leave_bus(),
        Event::Leave(false) => probe.drive.faults_mut().wake(),
        Event::Wait { ns } => probe.wait(*ns),
    }
}

proptest! {
    #[test]
    fn sum_of_accepted_steps_is_in_the_books(events in prop::collection::vec(event(), 1..200)) {
        let mut probe = Probe::v1_6a();
        let (mut sum, mut accepted, mut ignored, mut is_gone) = (0_i64, 0, 0, false);
        for event in &events {
            // Faults act and alarms come up to this instant before the drive hears the frame.
            probe.wait(0);
            if let Event::Step(step) = event {
                if accepts(&probe, is_gone) {
                    (sum, accepted) = (sum + i64::from(*step), accepted + 1);
                } else if probe.drive.is_ready() && !is_gone {
                    ignored += 1;
                }
            }
            if let Event::Leave(gone) = event {
                is_gone = *gone;
            }
            play(&mut probe, event);
        }
        let books = probe.drive.books();
        prop_assert_eq!(probe.drive.commanded_counts(), sum);
        prop_assert_eq!((books.pd_frames, books.pd_frames_ignored), (accepted, ignored));
    }

    #[test]
    fn undisturbed_shaft_arrives_at_the_sum_of_all_commands(
        steps in prop::collection::vec((-500..=500_i16, 0..3 * MS), 1..100),
        moves in prop::collection::vec((-20_000..=20_000_i16, 0..300 * MS), 0..4),
    ) {
        let mut probe = Probe::new(DynDriveConfig { lost_phase_steps: None, ..drive_1() });
        let mut sum = 0;
        for (step, pause_ns) in steps.iter().chain(&moves).chain(&steps) {
            let id = if moves.contains(&(*step, *pause_ns)) { 0x023 } else { 0x03C };
            probe.hear(id, &step.to_be_bytes());
            sum += i64::from(*step);
            probe.wait(*pause_ns);
        }
        probe.wait(5_000 * MS);
        let books = probe.drive.books();
        prop_assert_eq!(books.commanded_counts + books.relative_move_counts, sum);
        prop_assert_eq!(probe.position(), sum);
        prop_assert_eq!(probe.status(), 0x00);
        prop_assert_eq!(probe.drive.next_event_ns(), None);
    }

    /// Queries and needless runs in between change neither what is sent nor where the shaft goes.
    #[test]
    fn looking_and_running_more_often_changes_nothing(
        events in prop::collection::vec(event(), 1..100),
        extra_ns in 1_000..2 * MS,
    ) {
        let (mut seldom, mut often) = (Probe::v1_6a(), Probe::v1_6a());
        for event in &events {
            for probe in [&mut seldom, &mut often] {
                probe.wait(0);
            }
            play(&mut seldom, event);
            let Event::Wait { ns } = event else {
                play(&mut often, event);
                continue;
            };
            let until_ns = often.now_ns + ns;
            while often.now_ns < until_ns {
                often.wait(extra_ns.min(until_ns - often.now_ns));
                let now_ns = often.now_ns;
                let sent = &mut often.sent;
                often.drive.run(now_ns, &mut |frame| sent.push((now_ns, frame.to_string())));
                prop_assert!(often.drive.speed_rpm(now_ns).is_finite());
            }
            prop_assert_eq!(seldom.now_ns, often.now_ns);
        }
        prop_assert_eq!(&seldom.sent, &often.sent);
        let now_ns = seldom.now_ns;
        prop_assert_eq!(seldom.drive.travel_counts(now_ns), often.drive.travel_counts(now_ns));
        prop_assert_eq!(seldom.drive.books(), often.drive.books());
    }
}

#[test]
fn one_set_point_by_hand() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x03C, &[0xFF, 0x88]);
    assert_eq!(probe.drive.commanded_counts(), -120);
    probe.hear(0x03C, &[0x88]);
    probe.hear(0x03C, &[0x40, 0x00]);
    probe.hear(0x05C, &[0x01]);
    assert_eq!(probe.drive.commanded_counts(), 16_144);
    assert_eq!(probe.drive.books().pd_frames, 3);
}

#[test]
fn broadcast_set_point_moves_every_drive() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x01C, &[0x05]);
    assert_eq!(probe.drive.commanded_counts(), 5);
}

#[test]
fn drives_on_a_bus_follow_a_stream_and_answer() {
    use embedded_can::nb::Can;

    let configs = (1..=3).map(|id| DynDriveConfig::numbered(id).unwrap());
    let (mut bench, drives) = Bench::with_drives(BitRate::Kbit1000, configs);
    let master = bench.add_master(ControllerConfig::device());
    bench.advance_to(150 * MS);
    for cycle in 0..100 {
        bench.advance_to((150 + cycle) * MS);
        for id in [0x03C, 0x05C, 0x07C] {
            bench.port(master).transmit(&standard(id, &[0x64])).unwrap();
        }
    }
    bench.advance_to(400 * MS);
    bench
        .port(master)
        .transmit(&standard(0x04E, &[0x1B]))
        .unwrap();
    bench.advance_to(401 * MS);
    assert_eq!(
        bench.port(master).receive(),
        Ok(standard(0x04E, &[0x27, 0x10]))
    );
    let now_ns = bench.now_ns();
    for drive in drives {
        let drive = bench.device(drive);
        assert_eq!(
            (drive.commanded_counts(), drive.position_counts(now_ns)),
            (10_000, 10_000)
        );
    }
}
