//! The serial client against simulated drives on a virtual line, in virtual time.

use std::num::NonZeroU8;

use drive_sim::{
    Bench, BitRate, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, Frame, NodeId,
    SerialLine, SplitMix64, TxOrder,
};
use dyn_serial::{
    Address, Answer, Client, Counts28, Dialect, DriveId, DriveStatus, Failure, GeneralId, MainGain,
    Poll, ReadSelector, Reply, Request, Timing,
};
use embedded_can::nb::Can;
use embedded_can::{Frame as _, StandardId};

const MS: u64 = 1_000_000;

/// How far time goes on while the client waits.
const STEP_NS: u64 = 100_000;

/// What a drive holds back a packet in a chain: the seven bytes of the longest one.
const RELAY_NS: u64 = 7 * 260_417;

/// A host with a client, a line, and drives that are also on a CAN bus.
struct Host {
    bench: Bench<DynDrive>,
    can: NodeId,
    drives: Vec<DeviceId>,
    line: SerialLine,
    client: Client,
    /// Noise on the way to the host, when there is any: 1 byte in so many calls.
    noise: Option<SplitMix64>,
}

impl Host {
    fn new(ids: &[i32], timing: Timing, relay_ns: u64) -> Self {
        let configs = ids.iter().map(|id| DynDriveConfig::numbered(*id).unwrap());
        let (mut bench, drives) = Bench::with_drives(BitRate::Kbit1000, configs);
        let can = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        bench.advance_to(200 * MS);
        Self {
            line: SerialLine::chain(drives.iter().copied(), relay_ns),
            bench,
            can,
            drives,
            client: Client::new(Dialect::MANUAL, timing),
            noise: None,
        }
    }

    fn ask(&mut self, to: Address, request: &Request) -> Result<Answer, Failure> {
        let now_us = self.bench.now_ns() / 1_000;
        self.client
            .begin(now_us, to, request)
            .expect("the client is idle");
        loop {
            let now_ns = self.bench.now_ns();
            match self.client.poll(now_ns / 1_000) {
                Poll::Done(result) => return result,
                Poll::Transmit(packet) => self.line.write(now_ns, packet.as_bytes()),
                _ => self.pass_time(now_ns + STEP_NS),
            }
        }
    }

    fn pass_time(&mut self, until_ns: u64) {
        self.line.advance_to(&mut self.bench, until_ns);
        let mut bytes = self.line.read(until_ns);
        if let Some(random) = &mut self.noise
            && random.up_to(39) == 0
        {
            let at = random.up_to(bytes.len() as u64) as usize;
            bytes.insert(at, random.next_u64() as u8);
        }
        for byte in bytes {
            self.client.receive(until_ns / 1_000, byte);
        }
    }

    fn read(&mut self, id: i32, request: &Request) -> Reply {
        match self.ask(drive(id), request) {
            Ok(Answer::Reply { from, reply }) if drive(id) == from.into() => reply,
            other => panic!("{request:?} to {id}: {other:?}"),
        }
    }

    fn command(&mut self, id: i32, request: &Request) {
        assert_eq!(self.ask(drive(id), request), Ok(Answer::Sent));
    }

    /// What the drives answer to a frame within 10 ms.
    fn ask_over_can(&mut self, id: u16, data: &[u8]) -> String {
        let frame = Frame::new(StandardId::new(id).unwrap(), data).unwrap();
        self.bench.port(self.can).transmit(&frame).unwrap();
        let until_ns = self.bench.now_ns() + 10 * MS;
        self.bench.advance_until_received(self.can, until_ns);
        self.bench.port(self.can).receive().unwrap().to_string()
    }

    fn drive(&self, index: usize) -> &DynDrive {
        self.bench.device(self.drives[index])
    }
}

fn drive(id: i32) -> Address {
    Address::Drive(DriveId::new(id).unwrap())
}

fn main_gain(value: i32) -> MainGain {
    MainGain::new(value).unwrap()
}

fn position(counts: i32) -> Reply {
    Reply::Position(Counts28::new(counts).unwrap())
}

#[test]
fn a_parameter_written_over_serial_is_read_back_over_can() {
    let mut host = Host::new(&[1], Timing::ONE_DRIVE, 0);
    host.command(1, &Request::SetMainGain(main_gain(100)));
    let read_back = host.read(1, &Request::ReadMainGain);
    assert_eq!(read_back, Reply::MainGain(main_gain(100)));
    // Read_Param_Group1: main gain 64h.
    assert_eq!(host.ask_over_can(0x033, &[]), "033#64140A7F");
}

#[test]
fn a_move_over_serial_ends_where_it_was_sent() {
    let mut host = Host::new(&[1], Timing::ONE_DRIVE, 0);
    let distance = Counts28::new(-20_000).unwrap();
    host.command(1, &Request::GoRelativePos(distance));
    let moving = host.read(1, &Request::ReadDriveStatus);
    assert!(matches!(moving, Reply::Status(status) if status.motion_busy()));
    let end_ns = host.bench.now_ns() + 2_000 * MS;
    host.pass_time(end_ns);
    let status = host.read(1, &Request::ReadDriveStatus);
    assert_eq!(status, Reply::Status(DriveStatus::from_byte(0)));
    let read = Request::GeneralRead(ReadSelector::Position);
    assert_eq!(host.read(1, &read), position(-20_000));
}

#[test]
fn every_drive_of_a_chain_is_found_and_nobody_else() {
    let ids = [1, 2, 5, 9, 20, 40, 62, 63];
    let drives = NonZeroU8::new(ids.len() as u8).unwrap();
    let timing = Timing {
        attempts: NonZeroU8::MIN,
        ..Timing::chain(drives)
    };
    let mut host = Host::new(&ids, timing, RELAY_NS);
    let found: Vec<i32> = DriveId::all()
        .filter(|id| host.ask((*id).into(), &Request::ReadDriveId).is_ok())
        .map(|id| id.get().into())
        .collect();
    assert_eq!(found, ids);
}

#[test]
fn the_timing_of_one_drive_is_too_short_for_a_long_chain() {
    let ids: Vec<i32> = (1..=32).collect();
    let once = Timing {
        attempts: NonZeroU8::MIN,
        ..Timing::ONE_DRIVE
    };
    let mut host = Host::new(&ids, once, RELAY_NS);
    let last = host.ask(drive(32), &Request::ReadDriveId);
    assert_eq!(last, Err(Failure::NoReply { attempts: 1 }));
}

#[test]
fn a_lost_reply_is_asked_for_again_and_a_command_never_doubled() {
    let mut host = Host::new(&[1], Timing::ONE_DRIVE, 0);
    let step = Request::GoRelativePos(Counts28::new(10).unwrap());
    for _ in 0..20 {
        let id = host.drives[0];
        host.bench.device_mut(id).faults_mut().drop_next_replies(2);
        host.command(1, &step);
        host.read(1, &Request::ReadDriveStatus);
    }
    assert_eq!(host.drive(0).books().relative_move_counts, 200);
    assert_eq!(host.client.traffic().retries, 40);
}

#[test]
fn damaged_replies_are_never_believed() {
    let mut host = Host::new(&[1], Timing::ONE_DRIVE, 0);
    let id = host.drives[0];
    for damage in [
        drive_sim::DriveFaults::truncate_next_reply,
        drive_sim::DriveFaults::lengthen_next_reply,
        drive_sim::DriveFaults::duplicate_next_reply,
    ] {
        damage(host.bench.device_mut(id).faults_mut());
        let gear = host.read(1, &Request::ReadGearNumber);
        assert!(matches!(gear, Reply::GearNumber(gear) if gear.get() == 4_096));
    }
    let (line, traffic) = (host.client.line(), host.client.traffic());
    assert_eq!((line.truncated, traffic.retries), (1, 1));
    // The byte too many of one reply, and the second copy of another.
    assert_eq!((line.stray_bytes, traffic.unexpected), (1, 0));
}

#[test]
fn noise_costs_repetitions_and_no_wrong_value() {
    let mut host = Host::new(&[1, 2, 3], Timing::ONE_DRIVE, 0);
    host.noise = Some(SplitMix64::new(1));
    for round in 0..200 {
        for id in 1..=3 {
            let read = Request::GeneralRead(ReadSelector::Position);
            // Three attempts can all be hit; a reply that comes is the right one.
            if let Ok(answer) = host.ask(drive(id), &read) {
                let expected = Answer::Reply {
                    from: DriveId::new(id).unwrap(),
                    reply: position(0),
                };
                assert_eq!(answer, expected, "round {round}, drive {id}");
            }
        }
    }
    let (line, traffic) = (host.client.line(), host.client.traffic());
    assert!(line.stray_bytes > 0 && line.truncated > 0, "{line:?}");
    assert!(traffic.retries > 0 && traffic.replies > 590, "{traffic:?}");
}

#[test]
fn a_lone_drive_of_unknown_id_is_found_and_given_one() {
    let mut host = Host::new(&[17], Timing::ONE_DRIVE, 0);
    let dialect = Dialect {
        general_id: GeneralId::LoneDrive,
        ..Dialect::MANUAL
    };
    host.client = Client::new(dialect, Timing::ONE_DRIVE);
    let answer = host.ask(Address::All, &Request::ReadDriveId);
    let id = DriveId::new(17).unwrap();
    let expected = Answer::Reply {
        from: id,
        reply: Reply::DriveId(id),
    };
    assert_eq!(answer, Ok(expected));
    host.command(17, &Request::AssignDriveId(DriveId::new(4).unwrap()));
    // The command is on its way, and done when its last byte is through.
    let now_ns = host.bench.now_ns();
    host.pass_time(now_ns + 10 * MS);
    let id = host.drives[0];
    host.bench.device_mut(id).faults_mut().reboot();
    host.pass_time(now_ns + 200 * MS);
    host.read(4, &Request::ReadDriveId);
    // 1.6A answers under its new id over CAN as well: Read_Drive_ID.
    assert_eq!(host.ask_over_can(0x086, &[]), "086#04");
}
