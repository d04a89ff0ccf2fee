//! LPUART1 of the STM32G474, which is the debugger's serial port on the Nucleo board, with DMA1: channel 1 receives, channel 2 transmits.

use embassy_stm32::pac::bdma::vals::Dir;
use embassy_stm32::pac::bdma::{Ch, Dma};
use embassy_stm32::pac::usart::regs::Brr;
use embassy_stm32::pac::{DMA1, DMAMUX1, LPUART1, RCC};
use embassy_stm32::{peripherals, rcc};

use super::BIT_RATE;

/// LPUART1 on PA2 and PA3 (STM32G474 data sheet, table 13).
pub(super) const PIN_FUNCTION: u8 = 12;

const CONTROLLER: Dma = DMA1;
/// Channels count from 0 here; the multiplexer has the same order.
const RECEIVE: usize = 0;
const TRANSMIT: usize = 1;
/// Requests of the multiplexer (RM0440, table 91).
const RECEIVE_REQUEST: u8 = 34;
const TRANSMIT_REQUEST: u8 = 35;

/// Starts the port, which receives into the memory at `memory` for ever.
pub(super) fn start(memory: u32, bytes: usize) {
    RCC.ahb1enr().modify(|clocks| {
        clocks.set_dma1en(true);
        clocks.set_dmamux1en(true);
    });
    RCC.apb1enr2().modify(|clocks| clocks.set_lpuart1en(true));
    let clock = u64::from(rcc::frequency::<peripherals::LPUART1>().0);
    // The register counts 256ths of a clock of a bit (RM0440, section 38.4.7).
    let divider = (256 * clock + u64::from(BIT_RATE) / 2) / u64::from(BIT_RATE);
    LPUART1.brr().write_value(Brr(divider as u32));
    for (channel, request) in [(RECEIVE, RECEIVE_REQUEST), (TRANSMIT, TRANSMIT_REQUEST)] {
        DMAMUX1
            .ccr(channel)
            .write(|route| route.set_dmareq_id(request));
    }
    let receive = CONTROLLER.ch(RECEIVE);
    prepare(
        receive,
        (LPUART1.rdr().as_ptr() as u32, memory, bytes),
        Dir::FROM_PERIPHERAL,
    );
    receive.cr().modify(|control| {
        control.set_circ(true);
        control.set_en(true);
    });
    LPUART1.cr3().write(|control| {
        control.set_dmar(true);
        control.set_dmat(true);
    });
    LPUART1.cr1().write(|control| {
        control.set_ue(true);
        control.set_re(true);
        control.set_te(true);
    });
}

/// Bytes left until the transfer begins anew.
pub(super) fn receive_left() -> usize {
    CONTROLLER.ch(RECEIVE).ndtr().read().ndt().into()
}

/// Whether nothing is transmitted: the channel stays on, its counter is at 0 then.
pub(super) fn is_transmit_over() -> bool {
    let channel = CONTROLLER.ch(TRANSMIT);
    !channel.cr().read().en() || channel.ndtr().read().ndt() == 0
}

/// Transmits what is in memory.
pub(super) fn transmit(memory: u32, bytes: usize) {
    let channel = CONTROLLER.ch(TRANSMIT);
    channel.cr().modify(|control| control.set_en(false));
    CONTROLLER.ifcr().write(|flags| {
        flags.set_tcif(TRANSMIT, true);
        flags.set_htif(TRANSMIT, true);
        flags.set_teif(TRANSMIT, true);
    });
    prepare(
        channel,
        (LPUART1.tdr().as_ptr() as u32, memory, bytes),
        Dir::FROM_MEMORY,
    );
    channel.cr().modify(|control| control.set_en(true));
}

/// Whether the status shows an error, which is cleared.
pub(super) fn take_error() -> bool {
    let status = LPUART1.isr().read();
    let has_error = status.ore() || status.fe() || status.ne();
    if has_error {
        LPUART1.icr().write(|clear| {
            clear.set_ore(true);
            clear.set_fe(true);
            clear.set_ne(true);
        });
    }
    has_error
}

fn prepare(channel: Ch, (register, memory, bytes): (u32, u32, usize), direction: Dir) {
    channel.par().write_value(register);
    channel.mar().write_value(memory);
    channel.ndtr().write(|count| count.set_ndt(bytes as u16));
    channel.cr().write(|control| {
        control.set_minc(true);
        control.set_dir(direction);
    });
}
