//! The registers of the STM32F4's controllers (RM0090, section 10.5), in direct mode.

use super::stream::{Direction, Events, Stream};
use super::{Dma, STREAMS};

const CR_ENABLE: u32 = 1;
const CR_ERROR_ENABLE: u32 = 1 << 2;
const CR_HALF_ENABLE: u32 = 1 << 3;
const CR_COMPLETE_ENABLE: u32 = 1 << 4;
/// What may be written while the stream is enabled.
const CR_ENABLES: u32 = CR_ERROR_ENABLE | CR_HALF_ENABLE | CR_COMPLETE_ENABLE | 1 << 1;
const CR_PERIPHERAL_CONTROLS_FLOW: u32 = 1 << 5;
const CR_CIRCULAR: u32 = 1 << 8;
const CR_PERIPHERAL_INCREMENTS: u32 = 1 << 9;
const CR_MEMORY_INCREMENTS: u32 = 1 << 10;
const CR_INCREMENT_OFFSET: u32 = 1 << 15;
const CR_DOUBLE_BUFFER: u32 = 1 << 18;
const CR_NOT_MODELLED: u32 = CR_PERIPHERAL_CONTROLS_FLOW | CR_INCREMENT_OFFSET | CR_DOUBLE_BUFFER;
/// What FCR shows of an empty FIFO.
const FCR_EMPTY: u32 = 0x20;
const FCR_FIFO_MODE: u32 = 1 << 2;
/// Flags of each stream of a half of the controller, in LISR and HISR.
const FLAG_PLACES: [u32; 4] = [0, 6, 16, 22];
const FLAG_ERROR: u32 = 1 << 3;
const FLAG_HALF: u32 = 1 << 4;
const FLAG_COMPLETE: u32 = 1 << 5;

/// Stream and register of an offset.
fn place(offset: u32) -> Option<(usize, u32)> {
    let offset = offset.checked_sub(0x10)?;
    let stream = (offset / 0x18) as usize;
    (stream < STREAMS).then_some((stream, offset % 0x18))
}

impl Dma {
    pub(super) fn read_streams(&self, offset: u32) -> u32 {
        if let 0x00 | 0x04 = offset {
            return self.stream_flags(offset as usize);
        }
        let Some((index, register)) = place(offset) else {
            return 0;
        };
        let stream = &self.streams[index];
        match register {
            0x00 => stream.control | u32::from(stream.enabled),
            0x04 => stream.remaining,
            0x08 => stream.peripheral,
            0x0C => stream.memory,
            0x10 => stream.others[0],
            _ => stream.others[1] | FCR_EMPTY,
        }
    }

    /// LISR, at 0, or HISR, at 4.
    fn stream_flags(&self, first: usize) -> u32 {
        let streams = self.streams[first..first + 4].iter();
        streams.zip(FLAG_PLACES).fold(0, |all, (stream, place)| {
            let bit = |set: bool, flag: u32| if set { flag << place } else { 0 };
            all | bit(stream.events.error, FLAG_ERROR)
                | bit(stream.events.half, FLAG_HALF)
                | bit(stream.events.complete, FLAG_COMPLETE)
        })
    }

    fn clear_stream_flags(&mut self, first: usize, value: u32) {
        for (stream, place) in self.streams[first..first + 4].iter_mut().zip(FLAG_PLACES) {
            let events = &mut stream.events;
            events.error &= value >> place & FLAG_ERROR == 0;
            events.half &= value >> place & FLAG_HALF == 0;
            events.complete &= value >> place & FLAG_COMPLETE == 0;
        }
    }

    pub(super) fn write_streams(
        &mut self,
        offset: u32,
        value: u32,
        served: impl Fn(usize, u32) -> bool,
    ) {
        if let 0x08 | 0x0C = offset {
            return self.clear_stream_flags(offset as usize - 8, value);
        }
        let Some((index, register)) = place(offset) else {
            return;
        };
        let number = self.wiring.number;
        let stream = &mut self.streams[index];
        match register {
            0x00 => {
                stream.write_control(value);
                if !stream.enabled && value & CR_ENABLE != 0 {
                    stream.check(number, index);
                    assert!(
                        served(index, stream.channel),
                        "DMA{number} stream {index}, channel {}: the peripheral behind it is not modelled",
                        stream.channel
                    );
                    stream.enable();
                }
            }
            // While it is enabled, addresses and number of items cannot be written.
            _ if stream.enabled => {}
            0x04 => stream.remaining = value & 0xFFFF,
            0x08 => stream.peripheral = value,
            0x0C => stream.memory = value,
            0x10 => stream.others[0] = value,
            _ => stream.others[1] = value & 0x87,
        }
    }
}

impl Stream {
    fn write_control(&mut self, value: u32) {
        if self.enabled && value & CR_ENABLE != 0 {
            self.control = self.control & !CR_ENABLES | value & CR_ENABLES;
        } else {
            self.control = value & !CR_ENABLE;
        }
        if self.enabled && value & CR_ENABLE == 0 {
            // A stream that is disabled tells that its transfer is over (RM0090, section 10.3.14).
            self.enabled = false;
            self.events.complete = true;
        }
        let control = self.control;
        // In direct mode both sides have the size of the peripheral's (RM0090, section 10.5.5, MSIZE).
        self.sizes = [1 << (control >> 11 & 3); 2];
        self.circular = control & CR_CIRCULAR != 0;
        self.peripheral_increments = control & CR_PERIPHERAL_INCREMENTS != 0;
        self.memory_increments = control & CR_MEMORY_INCREMENTS != 0;
        self.priority = control >> 16 & 3;
        self.channel = control >> 25 & 7;
        self.direction = match control >> 6 & 3 {
            0 => Direction::ToMemory,
            _ => Direction::FromMemory,
        };
        self.enables = Events {
            error: control & CR_ERROR_ENABLE != 0,
            half: control & CR_HALF_ENABLE != 0,
            complete: control & CR_COMPLETE_ENABLE != 0,
        };
    }

    fn check(&self, number: usize, index: usize) {
        let name = format!("DMA{number} stream {index}");
        assert!(
            !self.events.any(),
            "{name} is enabled while flags of its last transfer are set (RM0090, section 10.3.17)"
        );
        assert!(
            self.control >> 6 & 3 < 2,
            "{name}: transfers from memory to memory are not modelled"
        );
        assert!(
            self.control >> 11 & 3 < 3,
            "{name}: PSIZE 3 is reserved (RM0090, section 10.5.5)"
        );
        assert_eq!(
            self.control & CR_NOT_MODELLED,
            0,
            "{name}: double buffers, flow control by the peripheral and PINCOS are not modelled"
        );
        assert_eq!(
            self.others[1] & FCR_FIFO_MODE,
            0,
            "{name}: of the FIFO modes only the direct mode is modelled"
        );
    }
}
