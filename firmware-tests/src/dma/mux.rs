//! The request multiplexer of the STM32G4 (RM0440, section 13): which peripheral asks which channel.

/// Channels: 0 to 7 go to DMA1, the others to DMA2.
const CHANNELS: usize = 16;
const CCR_REQUEST: u32 = 0x7F;
/// Synchronisation, events.
const CCR_NOT_MODELLED: u32 = 1 << 16 | 1 << 9;

/// The multiplexer.
#[derive(Debug, Clone, Default)]
pub struct Mux {
    control: [u32; CHANNELS],
}

impl Mux {
    /// The request that goes to a channel, counted over both controllers; 0 for none.
    #[must_use]
    pub fn request(&self, channel: usize) -> u32 {
        self.control[channel] & CCR_REQUEST
    }

    /// Reads a register.
    #[must_use]
    pub fn read(&self, offset: u32) -> u32 {
        let control = self.control.get(offset as usize / 4);
        control.copied().unwrap_or(0)
    }

    /// Writes a register.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled: synchronisation, events, the request generator.
    pub fn write(&mut self, offset: u32, value: u32) {
        match self.control.get_mut(offset as usize / 4) {
            Some(control) => {
                assert_eq!(
                    value & CCR_NOT_MODELLED,
                    0,
                    "DMAMUX channel {}: synchronisation and events are not modelled",
                    offset / 4
                );
                *control = value;
            }
            None => assert_eq!(
                value, 0,
                "DMAMUX: the request generator is not modelled, offset {offset:#x}"
            ),
        }
    }
}
