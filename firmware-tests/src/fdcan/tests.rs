//! The controller at its registers: what the adapter of the firmware relies on, and that each law can be broken.

use drive_sim::{BitRate, Bus, ControllerConfig, FrameMatch, LogMode, ScriptedFaults};
use embedded_can::nb::Can as _;
use embedded_can::{ExtendedId, Frame as _, StandardId};

use super::*;
use crate::chip;

const US: u64 = 1_000;
const MS: u64 = 1_000_000;
/// After a reset the bus has 16 MHz: 16 quanta of one clock are 1 Mbit/s.
const NBTP_1_MBIT: u32 = 1 << 25 | 12 << 8 | 1;
const CCCR: u32 = 0x18;
const ECR: u32 = 0x40;
const PSR: u32 = 0x44;
const TXBRP: u32 = 0xC8;
const TXBAR: u32 = 0xCC;
const TXBCR: u32 = 0xD0;
const CHANGE: u32 = CCCR_INIT | CCCR_CHANGE_ENABLE;

struct Lone {
    can: FdCan,
    wire: Wire,
    clock: Clock,
    other: NodeId,
}

impl Lone {
    /// A controller on the bus with one other node, function code 0x1D passed to FIFO 1 and all others to FIFO 0.
    fn on_bus() -> Self {
        let mut lone = Self::set_up(NBTP_1_MBIT);
        lone.run_to(20 * US);
        lone
    }

    fn set_up(bit_timing: u32) -> Self {
        let mut bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut wire = Wire::new(bus);
        let other = wire.add_master(ControllerConfig::device());
        let can = FdCan::new(&mut wire);
        let clock = Clock::new(&chip::STM32G474, 24_000_000);
        let mut lone = Self {
            can,
            wire,
            clock,
            other,
        };
        lone.write(CCCR, CHANGE);
        lone.write(0x1C, bit_timing);
        lone.can.memory()[..2]
            .copy_from_slice(&[2 << 30 | 2 << 27 | 0x1D << 16 | 0x1F, 1 << 27 | 0x7FF]);
        lone.write(0x80, 2 << 16 | 2 << 4 | 2 << 2 | 3);
        lone.write(0xDC, 7);
        lone.write(CCCR, 0);
        lone
    }

    fn write(&mut self, offset: u32, value: u32) {
        self.can.write(&mut self.wire, offset, value, &self.clock);
    }

    fn read(&mut self, offset: u32) -> u32 {
        self.can.read(&self.wire, offset)
    }

    fn run_to(&mut self, ns: u64) {
        self.can.advance(&mut self.wire, ns);
    }

    /// Queues an empty frame at the place that the controller names.
    fn request(&mut self, id: u32) {
        let place = self.read(0xC4) >> 16 & 3;
        let first = 0x278 / 4 + 18 * place as usize;
        self.can.memory()[first..first + 2].copy_from_slice(&[id << 18, 0]);
        self.write(TXBAR, 1 << place);
    }

    fn send_from_other(&mut self, frame: &Frame) {
        let other = self.other;
        self.wire.port(other).transmit(frame).unwrap();
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
fn it_joins_after_eleven_recessive_bits_and_only_at_the_right_bit_rate() {
    let mut lone = Lone::set_up(NBTP_1_MBIT);
    lone.run_to(10 * US);
    assert_eq!(lone.read(PSR) >> 3 & 3, 0);
    lone.run_to(11 * US);
    assert_eq!(lone.read(PSR) >> 3 & 3, 1);
    let mut lone = Lone::set_up(NBTP_1_MBIT | 1 << 16);
    lone.run_to(100 * MS);
    assert_eq!(lone.read(PSR) >> 3 & 3, 0);
}

#[test]
fn frames_go_out_in_the_order_of_request_and_a_fourth_has_no_room() {
    let mut lone = Lone::on_bus();
    for id in [0x300, 0x200, 0x100] {
        lone.request(id);
    }
    assert_eq!(lone.read(0xC4) >> 21 & 1, 1);
    lone.run_to(MS);
    assert_eq!(lone.ids_on_wire(), ["300#", "200#", "100#"]);
    assert_eq!((lone.read(TXBRP), lone.read(0xD4)), (0, 7));
    assert_eq!(lone.read(0x50) & IR_SENT, IR_SENT);
}

#[test]
fn filters_choose_the_fifo_and_keep_extended_and_remote_frames_out() {
    let mut lone = Lone::on_bus();
    let remote = Frame::new_remote(StandardId::new(0x3A).unwrap(), 0).unwrap();
    let extended = Frame::new(ExtendedId::new(0x3A).unwrap(), &[]).unwrap();
    for frame in [frame(0x3A), frame(0x3D), remote, extended] {
        lone.send_from_other(&frame);
    }
    lone.run_to(2 * MS);
    assert_eq!((lone.read(0x90) & 0xF, lone.read(0x98) & 0xF), (1, 1));
    assert_eq!(lone.can.unfiltered(), 2);
    let first = 0xB0 / 4;
    let element = &lone.can.memory()[first..first + 3];
    assert_eq!(element, [0x3A << 18, 2 << 16, 0x0201]);
    lone.write(0x94, 0);
    assert_eq!(lone.read(0x90) & 0xF, 0);
}

#[test]
fn four_frames_without_a_read_lose_the_last() {
    let mut lone = Lone::on_bus();
    (1..=4).for_each(|id| lone.send_from_other(&frame(id)));
    lone.run_to(MS);
    assert_eq!(lone.read(0x90) & 0xF, 3);
    assert_eq!(lone.read(0x50) & 7, IR_NEW | IR_LOST);
    assert_eq!(lone.can.overruns(), 1);
    lone.write(0x50, IR_LOST);
    assert_eq!(lone.read(0x50) & IR_LOST, 0);
}

#[test]
fn the_last_error_is_told_once_and_every_error_is_counted_until_it_is_read() {
    let mut lone = Lone::on_bus();
    lone.wire
        .bus_mut()
        .faults_mut()
        .corrupt_next(FrameMatch::ANY, 5, 20);
    lone.request(0x300);
    // The fifth attempt has failed, the sixth is on the wire.
    lone.run_to(20 * US + 5 * 45 * US);
    let code = lone.read(PSR) & 7;
    assert!(code != 0 && code != LEC_UNCHANGED, "{code}");
    assert_eq!(lone.read(PSR) & 7, LEC_UNCHANGED);
    let counted = lone.read(ECR) >> 16;
    lone.run_to(5 * MS);
    assert_eq!(counted + (lone.read(ECR) >> 16), 5);
    assert_eq!(lone.read(ECR) >> 16, 0);
}

#[test]
fn bus_off_requests_initialisation_keeps_the_frames_and_lasts_128_sequences() {
    let mut lone = Lone::on_bus();
    lone.wire
        .bus_mut()
        .faults_mut()
        .corrupt_next(FrameMatch::ANY, 32, 20);
    lone.request(0x300);
    lone.run_to(10 * MS);
    assert_eq!((lone.read(PSR) >> 7 & 1, lone.read(CCCR)), (1, CCCR_INIT));
    assert_eq!(lone.read(TXBRP), 1);
    lone.write(CCCR, 0);
    lone.run_to(11 * MS);
    assert_eq!(lone.read(PSR) >> 7 & 1, 1);
    lone.run_to(12 * MS);
    assert_eq!(lone.read(PSR) >> 7 & 1, 0);
    lone.run_to(13 * MS);
    assert_eq!(lone.ids_on_wire().len(), 33, "what waited went out");
}

#[test]
fn a_cancelled_frame_does_not_go_out_and_the_change_enable_forgets_all() {
    for cancels in [true, false] {
        let mut lone = Lone::on_bus();
        lone.wire
            .bus_mut()
            .faults_mut()
            .corrupt_next(FrameMatch::ANY, 32, 20);
        lone.request(0x300);
        lone.run_to(10 * MS);
        if cancels {
            lone.write(TXBCR, 1);
            lone.run_to(11 * MS);
            assert_eq!((lone.read(TXBRP), lone.read(0xD8)), (0, 1));
        } else {
            lone.write(CCCR, CHANGE);
            assert_eq!(lone.read(TXBRP), 0);
        }
        lone.write(CCCR, 0);
        lone.run_to(20 * MS);
        assert_eq!(lone.ids_on_wire().len(), 32);
    }
}

#[test]
fn on_a_dominant_bus_it_does_not_join() {
    let mut lone = Lone::set_up(NBTP_1_MBIT);
    lone.can.hold_dominant(&lone.wire, &lone.clock, true);
    lone.run_to(100 * MS);
    assert_eq!(lone.read(PSR) >> 3 & 3, 0);
    lone.can.hold_dominant(&lone.wire, &lone.clock, false);
    lone.run_to(101 * MS);
    assert_eq!(lone.read(PSR) >> 3 & 3, 1);
}
