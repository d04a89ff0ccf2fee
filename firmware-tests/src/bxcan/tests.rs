//! The controller at its registers: what the driver of the firmware relies on, and that each law can be broken.

use drive_sim::{
    BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, FrameMatch, LogMode, ScriptedFaults,
};
use embedded_can::nb::Can as _;
use embedded_can::{Frame as _, StandardId};

use super::*;
use crate::chip;
use crate::connection::LEC_ACKNOWLEDGE;

const US: u64 = 1_000;
const MS: u64 = 1_000_000;
/// 14 quanta of a third of 42 MHz would be 1 Mbit/s; after a reset the bus has 16 MHz: 16 quanta, prescaler 1.
const BTR_1_MBIT: u32 = 1 << 20 | 12 << 16;
/// Awake 11 bits after the request, at the bit timing out of reset: 8 clocks of 16 MHz.
const AWAKE_NS: u64 = 11 * 500;
const MAILBOX_0: u32 = 0x180;
const TSR: u32 = 0x08;
const ESR: u32 = 0x18;

struct Lone {
    can: BxCan,
    wire: Wire,
    clock: Clock,
    other: NodeId,
}

impl Lone {
    /// A controller on the bus with one other node, all frames passed to FIFO 0.
    fn on_bus() -> Self {
        let mut lone = Self::asleep(BTR_1_MBIT);
        lone.run_to(20 * US);
        lone
    }

    fn asleep(bit_timing: u32) -> Self {
        let mut bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut wire = Wire::new(bus);
        let other = wire.add_master(ControllerConfig::device());
        let can = BxCan::new(&mut wire);
        let clock = Clock::new(&chip::STM32F405, 8_000_000);
        let mut lone = Self {
            can,
            wire,
            clock,
            other,
        };
        lone.write(0x00, MCR_INIT | MCR_FIRST_COME);
        lone.run_to(AWAKE_NS);
        lone.write(0x1C, bit_timing);
        lone.write(0x20C, 1);
        lone.write(0x21C, 1);
        lone.write(0x200, 0x2A1C_0E00);
        lone.write(0x00, MCR_FIRST_COME);
        lone
    }

    fn write(&mut self, offset: u32, value: u32) {
        self.can.write(&mut self.wire, offset, value, &self.clock);
    }

    fn read(&self, offset: u32) -> u32 {
        self.can.read(&self.wire, offset)
    }

    fn run_to(&mut self, ns: u64) {
        self.can.advance(&mut self.wire, ns);
    }

    fn request(&mut self, mailbox: u32, id: u32) {
        self.write(MAILBOX_0 + 16 * mailbox, id << 21 | 1);
    }

    fn ids_on_wire(&self) -> Vec<String> {
        let records = self.wire.bus().log().iter();
        records.map(|record| record.frame.to_string()).collect()
    }
}

fn frame(id: u16) -> Frame {
    Frame::new(StandardId::new(id).unwrap(), &[1, 2]).unwrap()
}

#[test]
fn it_joins_after_eleven_recessive_bits() {
    let mut lone = Lone::asleep(BTR_1_MBIT);
    lone.run_to(AWAKE_NS + 10 * US);
    assert_eq!(lone.read(0x04) & 3, 1);
    lone.run_to(AWAKE_NS + 11 * US);
    assert_eq!(lone.read(0x04) & 3, 0);
}

#[test]
fn it_never_joins_a_bus_of_another_bit_rate() {
    let mut lone = Lone::asleep(BTR_1_MBIT | 1);
    lone.run_to(100 * MS);
    assert_eq!(lone.read(0x04) & 3, 1);
}

#[test]
fn frames_go_out_in_the_order_of_request_and_complete() {
    let mut lone = Lone::on_bus();
    for (mailbox, id) in [(0, 0x300), (1, 0x200), (2, 0x100)] {
        lone.request(mailbox, id);
    }
    assert_eq!(lone.read(TSR) >> 26, 0);
    lone.run_to(MS);
    assert_eq!(lone.ids_on_wire(), ["300#", "200#", "100#"]);
    assert_eq!(lone.read(TSR), 7 << 26 | 0x03_0303);
}

#[test]
fn without_first_come_the_identifier_decides_even_while_the_bus_is_busy() {
    let mut lone = Lone::on_bus();
    lone.write(0x00, 0);
    let other = lone.other;
    lone.wire.port(other).transmit(&frame(0x080)).unwrap();
    lone.run_to(30 * US);
    lone.request(0, 0x300);
    lone.request(1, 0x200);
    lone.run_to(MS);
    assert_eq!(lone.ids_on_wire(), ["080#0102", "200#", "300#"]);
}

#[test]
fn without_acknowledge_the_frame_is_repeated_until_it_is_aborted() {
    let mut lone = Lone::on_bus();
    let other = lone.other;
    lone.wire.bus_mut().set_connected(other, false);
    lone.request(0, 0x300);
    lone.run_to(10 * MS);
    let esr = lone.read(ESR);
    assert_eq!((esr >> 16 & 0xFF, esr >> 4 & 7), (128, LEC_ACKNOWLEDGE));
    assert_eq!(esr & 0b111, 0b011);
    lone.write(TSR, 1 << 7);
    lone.run_to(11 * MS);
    assert_eq!(lone.read(TSR) & 0b11, 0b01);
    let attempts = lone.ids_on_wire().len();
    lone.run_to(20 * MS);
    assert_eq!(lone.ids_on_wire().len(), attempts);
}

#[test]
fn bus_off_lasts_until_initialisation_is_left_and_128_sequences_have_passed() {
    let mut lone = Lone::on_bus();
    lone.wire
        .bus_mut()
        .faults_mut()
        .corrupt_next(FrameMatch::ANY, 32, 20);
    lone.request(0, 0x300);
    lone.run_to(10 * MS);
    assert_eq!(lone.read(ESR) & 0b100, 0b100);
    lone.run_to(100 * MS);
    assert_eq!(lone.read(ESR) & 0b100, 0b100);
    lone.write(TSR, 1 << 7);
    lone.run_to(100 * MS + ABORT_NS);
    lone.write(0x00, MCR_FIRST_COME | MCR_INIT);
    lone.write(0x00, MCR_FIRST_COME);
    lone.run_to(100 * MS + 1_400 * US);
    assert_eq!(lone.read(ESR) & 0b100, 0b100);
    lone.run_to(102 * MS);
    assert_eq!(lone.read(ESR) & 0b111, 0);
}

#[test]
fn in_initialisation_no_frame_is_given_up() {
    let mut lone = Lone::on_bus();
    let other = lone.other;
    lone.wire.bus_mut().set_connected(other, false);
    lone.request(0, 0x300);
    lone.request(1, 0x301);
    lone.run_to(MS);
    lone.write(TSR, 1 << 15 | 1 << 7);
    lone.write(0x00, MCR_FIRST_COME | MCR_INIT);
    lone.run_to(10 * MS);
    assert_eq!(lone.read(TSR) >> 26, 0b100);
    lone.write(0x00, MCR_FIRST_COME);
    lone.run_to(11 * MS);
    assert_eq!(lone.read(TSR) >> 26, 0b111);
}

#[test]
fn on_a_dominant_bus_it_neither_wakes_nor_joins() {
    let mut lone = Lone::asleep(BTR_1_MBIT);
    let hold = |lone: &mut Lone, held| lone.can.hold_dominant(&lone.wire, &lone.clock, held);
    hold(&mut lone, true);
    lone.run_to(100 * MS);
    assert_eq!(lone.read(0x04) & 0x803, 1);
    lone.write(0x00, MCR_SOFTWARE_RESET);
    lone.write(0x00, MCR_INIT);
    lone.run_to(200 * MS);
    assert_eq!(lone.read(0x04) & 3, 2);
    hold(&mut lone, false);
    lone.run_to(200 * MS + AWAKE_NS);
    assert_eq!(lone.read(0x04) & 0x803, 0x801);
}

#[test]
fn four_frames_without_a_read_are_an_overrun() {
    let mut lone = Lone::on_bus();
    lone.write(0x14, 1 << 1);
    let other = lone.other;
    for id in 1..=4 {
        lone.wire.port(other).transmit(&frame(id)).unwrap();
    }
    lone.run_to(MS);
    assert_eq!(lone.read(0x0C), 3 | 1 << 3 | 1 << 4);
    assert!(lone.can.lines()[1].1);
    assert_eq!(lone.can.overruns(), 1);
}

#[test]
fn a_reset_takes_it_off_the_bus_and_forgets_its_frames() {
    let mut lone = Lone::on_bus();
    let other = lone.other;
    lone.wire.port(other).transmit(&frame(0x080)).unwrap();
    lone.run_to(30 * US);
    lone.request(0, 0x300);
    lone.write(0x00, MCR_SOFTWARE_RESET);
    lone.run_to(MS);
    assert_eq!((lone.read(0x04) & 3, lone.read(TSR) >> 26), (2, 7));
    assert!(!lone.ids_on_wire().contains(&"300#".to_owned()));
}

#[test]
fn drives_answer_on_the_same_wire() {
    let mut lone = Lone::on_bus();
    let drive = DynDrive::new(DynDriveConfig::numbered(1).unwrap());
    lone.wire
        .add_device(drive.into(), ControllerConfig::device());
    lone.run_to(200 * MS);
    // Read_Drive_Status of drive 1: function code 0x09.
    lone.write(MAILBOX_0 + 4, 0);
    lone.request(0, 0x029);
    lone.run_to(201 * MS);
    assert_eq!(lone.ids_on_wire()[0], "029#");
    assert_eq!(lone.read(0x1B0) >> 21, 0x029);
}
