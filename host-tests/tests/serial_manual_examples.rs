//! The worked examples of the serial chapter (DYN2 manual A1.8, section 7), with what is wrong in them.
//!
//! The bytes are written out from the manual. Where it prints a wrong intermediate value or byte, the note says so and the
//! entry of `docs/errata.md` is named.

use dyn_serial::{
    Address, CircularMove, Counts28, Dialect, DriveId, FeedRate, LinearMove, MainGain, Packet,
    ReadSelector, Reply, Request, SpeedRpm, Turn,
};

fn bytes(id: i32, request: Request) -> Vec<u8> {
    let drive = DriveId::new(id).expect("the examples use drives");
    let packet = request.encode(drive.into(), &Dialect::MANUAL);
    let packet = packet.expect("the examples are legal");
    let decoded = Request::decode(&packet, &Dialect::MANUAL);
    assert_eq!(decoded, Ok((Address::Drive(drive), request)));
    packet.as_bytes().to_vec()
}

fn counts(value: i32) -> Counts28 {
    Counts28::new(value).expect("28 bit")
}

fn speed(rpm: i32) -> Request {
    Request::TurnConstSpeed(SpeedRpm::new(rpm).expect("a speed"))
}

#[test]
fn packet_section_drive_8_at_50_rpm() {
    assert_eq!(bytes(8, speed(50)), [0x08, 0x8A, 0xB2, 0xC4]);
}

#[test]
fn example_1_set_origin_of_drive_3() {
    assert_eq!(bytes(3, Request::SetOrigin), [0x03, 0x80, 0x80, 0x83]);
}

#[test]
fn example_2_drive_3_back_to_zero() {
    let go = Request::GoAbsolutePos(counts(0));
    assert_eq!(bytes(3, go), [0x03, 0x81, 0x80, 0x84]);
}

/// The sum for the second byte lacks its length term of 0x20; the byte A3 is right (M2).
#[test]
fn example_3_drive_3_forward_by_120() {
    let go = Request::GoRelativePos(counts(120));
    assert_eq!(bytes(3, go), [0x03, 0xA3, 0x80, 0xF8, 0x9E]);
}

/// The sum adds the code 04 and lacks 0x20, and the threshold is printed as -63; the byte A3 is right (M3, M17).
#[test]
fn example_4_drive_3_backward_by_120() {
    let go = Request::GoRelativePos(counts(-120));
    assert_eq!(bytes(3, go), [0x03, 0xA3, 0xFF, 0x88, 0xAD]);
}

#[test]
fn example_5_drive_2_at_60_rpm() {
    assert_eq!(bytes(2, speed(60)), [0x02, 0x8A, 0xBC, 0xC8]);
}

/// The sum has a stray 0x40; the byte 8A is right (M4).
#[test]
fn example_6_drive_2_at_minus_60_rpm() {
    assert_eq!(bytes(2, speed(-60)), [0x02, 0x8A, 0xC4, 0xD0]);
}

/// The manual gives the arguments only; the bytes follow from the packet section.
#[test]
fn example_7_line_to_100_200_0() {
    let line = LinearMove {
        distances: [100, 200, 0].map(counts),
        feed_rate: FeedRate::new(3).expect("a feed rate"),
    };
    let packets = line.packets();
    let expected: [&[u8]; 4] = [
        &[0x7F, 0xA2, 0x80, 0xE4, 0x85],
        &[0x7F, 0xA2, 0x81, 0xC8, 0xEA],
        &[0x7F, 0x82, 0x80, 0x81],
        &[0x7F, 0x82, 0x83, 0x84],
    ];
    assert_eq!(packets.each_ref().map(Packet::as_bytes), expected);
}

/// Five packets are listed and four counted; the last word is plane * 256 + feed rate, with the operator missing (M15).
#[test]
fn example_8_half_circle_clockwise() {
    let arc = CircularMove {
        start: [-100, 0].map(counts),
        end: [100, 0].map(counts),
        plane: 0,
        turn: Turn::Clockwise,
        feed_rate: FeedRate::new(1).expect("a feed rate"),
    };
    let packets = arc.packets();
    let expected: [&[u8]; 5] = [
        &[0x7F, 0xA4, 0xFF, 0x9C, 0xBE],
        &[0x7F, 0x84, 0x80, 0x83],
        &[0x7F, 0xA4, 0x80, 0xE4, 0x87],
        &[0x7F, 0x84, 0x80, 0x83],
        &[0x7F, 0x84, 0x81, 0x84],
    ];
    assert_eq!(packets.each_ref().map(Packet::as_bytes), expected);
}

/// Examples 9 and 10 call the sample code, which sends the function code of the reply as the selector.
#[test]
fn examples_9_and_10_read_position_and_torque() {
    let read = Request::GeneralRead(ReadSelector::Position);
    assert_eq!(bytes(0, read), [0x00, 0x8E, 0x9B, 0xA9]);
    let read = Request::GeneralRead(ReadSelector::Torque);
    assert_eq!(bytes(0, read), [0x00, 0x8E, 0x9E, 0xAC]);
}

/// The sample code sends 10 as the dummy byte and reads the answer as a signed number, so that 100 comes back as -28 (M11).
#[test]
fn example_11_reads_the_main_gain() {
    let dialect = Dialect {
        dummy: 0x10.try_into().expect("seven bits"),
        ..Dialect::MANUAL
    };
    let packet = Request::ReadMainGain.encode(DriveId::FRESH.into(), &dialect);
    let packet = packet.expect("a read is legal");
    assert_eq!(packet.as_bytes(), [0x00, 0x98, 0x90, 0xA8]);
    let answer = Packet::parse(&[0x00, 0x90, 0xE4, 0xF4]).expect("a packet");
    let gain = Reply::MainGain(MainGain::new(100).expect("a gain"));
    assert_eq!(Reply::decode(&answer), Ok((DriveId::FRESH, gain)));
}

/// Section 7.4.2 prints 85 as the high byte of 1400 rpm, which is 760 rpm; 8A is right (M1).
#[test]
fn example_of_1400_rpm_with_the_right_byte() {
    assert_eq!(bytes(1, speed(1_400)), [0x01, 0xAA, 0x8A, 0xF8, 0xAD]);
    let printed = Packet::parse(&[0x01, 0xAA, 0x85, 0xF8, 0xA8]).expect("a packet");
    assert_eq!(
        Request::decode(&printed, &Dialect::MANUAL).map(|(_, request)| request),
        Ok(speed(760))
    );
    // -120 rpm, printed rightly.
    assert_eq!(bytes(1, speed(-120))[2..4], [0xFF, 0x88]);
}

/// Section 7.6 prints the second byte of Read_Drive_Status as that of Read_Drive_Config (M6).
#[test]
fn reading_the_status_has_its_own_code() {
    assert_eq!(bytes(1, Request::ReadDriveStatus)[1], 0b1000_1001);
    assert_eq!(bytes(1, Request::ReadDriveConfig)[1], 0b1000_1000);
}

/// The first line of the sample code's main function.
#[test]
fn sample_code_moves_drive_2_to_321456() {
    let go = Request::GoAbsolutePos(counts(321_456));
    assert_eq!(bytes(2, go), [0x02, 0xC1, 0x93, 0xCF, 0xB0, 0xD5]);
}
