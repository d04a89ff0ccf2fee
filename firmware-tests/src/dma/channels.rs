//! The registers of the STM32G4's controllers (RM0440, section 12.6).

use super::stream::{Direction, Events, Stream};
use super::{Dma, STREAMS};

const CCR_ENABLE: u32 = 1;
const CCR_COMPLETE_ENABLE: u32 = 1 << 1;
const CCR_HALF_ENABLE: u32 = 1 << 2;
const CCR_ERROR_ENABLE: u32 = 1 << 3;
const CCR_ENABLES: u32 = CCR_COMPLETE_ENABLE | CCR_HALF_ENABLE | CCR_ERROR_ENABLE;
const CCR_FROM_MEMORY: u32 = 1 << 4;
const CCR_CIRCULAR: u32 = 1 << 5;
const CCR_PERIPHERAL_INCREMENTS: u32 = 1 << 6;
const CCR_MEMORY_INCREMENTS: u32 = 1 << 7;
const CCR_MEMORY_TO_MEMORY: u32 = 1 << 14;
/// Flags of a channel, four bits each in ISR.
const FLAG_ANY: u32 = 1;
const FLAG_COMPLETE: u32 = 1 << 1;
const FLAG_HALF: u32 = 1 << 2;
const FLAG_ERROR: u32 = 1 << 3;

/// Channel, counted from 0, and register of an offset.
fn place(offset: u32) -> Option<(usize, u32)> {
    let offset = offset.checked_sub(0x08)?;
    let channel = (offset / 0x14) as usize;
    (channel < STREAMS).then_some((channel, offset % 0x14))
}

impl Dma {
    pub(super) fn read_channels(&self, offset: u32) -> u32 {
        if offset == 0 {
            return self.channel_flags();
        }
        let Some((index, register)) = place(offset) else {
            return 0;
        };
        let channel = &self.streams[index];
        match register {
            0x00 => channel.control | u32::from(channel.enabled),
            0x04 => channel.remaining,
            0x08 => channel.peripheral,
            0x0C => channel.memory,
            _ => 0,
        }
    }

    fn channel_flags(&self) -> u32 {
        let channels = self.streams.iter().enumerate();
        channels.fold(0, |all, (index, channel)| {
            let events = channel.events;
            let bit = |set: bool, flag: u32| if set { flag << (4 * index) } else { 0 };
            all | bit(events.any(), FLAG_ANY)
                | bit(events.complete, FLAG_COMPLETE)
                | bit(events.half, FLAG_HALF)
                | bit(events.error, FLAG_ERROR)
        })
    }

    fn clear_channel_flags(&mut self, value: u32) {
        for (index, channel) in self.streams.iter_mut().enumerate() {
            let flags = value >> (4 * index);
            let keeps = |flag: u32| flags & (flag | FLAG_ANY) == 0;
            channel.events.complete &= keeps(FLAG_COMPLETE);
            channel.events.half &= keeps(FLAG_HALF);
            channel.events.error &= keeps(FLAG_ERROR);
        }
    }

    pub(super) fn write_channels(
        &mut self,
        offset: u32,
        value: u32,
        served: impl Fn(usize, u32) -> bool,
    ) {
        if offset == 0x04 {
            return self.clear_channel_flags(value);
        }
        let Some((index, register)) = place(offset) else {
            return;
        };
        let name = format!("DMA{} channel {}", self.wiring.number, index + 1);
        let channel = &mut self.streams[index];
        match register {
            0x00 => {
                channel.write_channel_control(value);
                if !channel.enabled && value & CCR_ENABLE != 0 {
                    channel.check_channel(&name);
                    assert!(
                        served(index, 0),
                        "{name}: the peripheral behind its request is not modelled"
                    );
                    channel.enable();
                }
            }
            _ if channel.enabled => {}
            0x04 => channel.remaining = value & 0xFFFF,
            0x08 => channel.peripheral = value,
            0x0C => channel.memory = value,
            _ => {}
        }
    }
}

impl Stream {
    fn write_channel_control(&mut self, value: u32) {
        if self.enabled && value & CCR_ENABLE != 0 {
            self.control = self.control & !CCR_ENABLES | value & CCR_ENABLES;
        } else {
            self.control = value & !CCR_ENABLE;
            self.enabled = false;
        }
        let control = self.control;
        self.sizes = [8, 10].map(|at| 1 << (control >> at & 3));
        self.circular = control & CCR_CIRCULAR != 0;
        self.peripheral_increments = control & CCR_PERIPHERAL_INCREMENTS != 0;
        self.memory_increments = control & CCR_MEMORY_INCREMENTS != 0;
        self.priority = control >> 12 & 3;
        self.direction = if control & CCR_FROM_MEMORY != 0 {
            Direction::FromMemory
        } else {
            Direction::ToMemory
        };
        self.enables = Events {
            error: control & CCR_ERROR_ENABLE != 0,
            half: control & CCR_HALF_ENABLE != 0,
            complete: control & CCR_COMPLETE_ENABLE != 0,
        };
    }

    fn check_channel(&self, name: &str) {
        assert!(
            !self.events.error,
            "{name} is enabled while its transfer error is set (RM0440, section 12.4.4)"
        );
        assert_eq!(
            self.control & CCR_MEMORY_TO_MEMORY,
            0,
            "{name}: transfers from memory to memory are not modelled"
        );
        assert!(
            self.sizes.iter().all(|size| *size < 8),
            "{name}: PSIZE and MSIZE 3 are reserved (RM0440, section 12.6.3)"
        );
    }
}
