//! USART2 of the STM32F405 with DMA1: stream 5 receives, stream 6 transmits, both on channel 4 (RM0090, table 42).

use embassy_stm32::pac::dma::vals::Dir;
use embassy_stm32::pac::dma::{Dma, St};
use embassy_stm32::pac::usart::regs::Brr;
use embassy_stm32::pac::{DMA1, RCC, USART2};
use embassy_stm32::{peripherals, rcc};

use super::BIT_RATE;

/// USART2 on PA2 and PA3 (STM32F405 data sheet, table 9).
pub(super) const PIN_FUNCTION: u8 = 7;

const CONTROLLER: Dma = DMA1;
const CHANNEL: u8 = 4;
const RECEIVE: usize = 5;
const TRANSMIT: usize = 6;
/// Flags of a stream lie in one of two registers, four streams in each.
const STREAMS_OF_REGISTER: usize = 4;

/// Starts the port, which receives into the memory at `memory` for ever.
pub(super) fn start(memory: u32, bytes: usize) {
    RCC.ahb1enr().modify(|clocks| clocks.set_dma1en(true));
    RCC.apb1enr().modify(|clocks| clocks.set_usart2en(true));
    let clock = rcc::frequency::<peripherals::USART2>().0;
    // Sixteenfold oversampling: the register counts clocks of a bit.
    let divider = (clock + BIT_RATE / 2) / BIT_RATE;
    USART2.brr().write_value(Brr(divider));
    let receive = CONTROLLER.st(RECEIVE);
    prepare(receive, memory, bytes);
    receive.cr().modify(|control| {
        control.set_dir(Dir::PERIPHERAL_TO_MEMORY);
        control.set_circ(true);
        control.set_en(true);
    });
    USART2.cr3().write(|control| {
        control.set_dmar(true);
        control.set_dmat(true);
    });
    USART2.cr1().write(|control| {
        control.set_ue(true);
        control.set_re(true);
        control.set_te(true);
    });
}

/// Bytes left until the transfer begins anew.
pub(super) fn receive_left() -> usize {
    CONTROLLER.st(RECEIVE).ndtr().read().ndt().into()
}

/// Whether nothing is transmitted: the stream switches itself off.
pub(super) fn is_transmit_over() -> bool {
    !CONTROLLER.st(TRANSMIT).cr().read().en()
}

/// Transmits what is in memory.
pub(super) fn transmit(memory: u32, bytes: usize) {
    let stream = CONTROLLER.st(TRANSMIT);
    CONTROLLER
        .ifcr(TRANSMIT / STREAMS_OF_REGISTER)
        .write(|flags| {
            let place = TRANSMIT % STREAMS_OF_REGISTER;
            flags.set_tcif(place, true);
            flags.set_htif(place, true);
            flags.set_teif(place, true);
            flags.set_dmeif(place, true);
            flags.set_feif(place, true);
        });
    prepare(stream, memory, bytes);
    stream.cr().modify(|control| {
        control.set_dir(Dir::MEMORY_TO_PERIPHERAL);
        control.set_en(true);
    });
}

/// Whether the status shows an error. It goes with the next byte: this look and the DMA's read of the data, in this order, clear it
/// (RM0090, section 30.6.1).
pub(super) fn take_error() -> bool {
    let status = USART2.sr().read();
    status.ore() || status.fe() || status.ne()
}

fn prepare(stream: St, memory: u32, bytes: usize) {
    stream.par().write_value(USART2.dr().as_ptr() as u32);
    stream.m0ar().write_value(memory);
    stream.ndtr().write(|count| count.set_ndt(bytes as u16));
    stream.cr().write(|control| {
        control.set_chsel(CHANNEL);
        control.set_minc(true);
    });
}
