//! The firmware's log: taken out of its RTT buffer as a debug probe does, and decoded with the table in the ELF file.

use defmt_decoder::{DecodeError, StreamDecoder, Table};

use crate::image::Image;

/// Offsets in the RTT control block: fields of the first up-channel (SEGGER RTT, as defmt-rtt lays it out).
const BUFFER: u32 = 28;
const SIZE: u32 = 32;
const WRITE: u32 = 36;
const READ: u32 = 40;

/// Memory as the debug probe sees it.
pub trait Memory {
    /// Reads bytes.
    fn read(&self, address: u32, bytes: &mut [u8]);
    /// Writes a word.
    fn write_word(&mut self, address: u32, value: u32);

    /// Reads a word.
    fn word(&self, address: u32) -> u32 {
        let mut bytes = [0; 4];
        self.read(address, &mut bytes);
        u32::from_le_bytes(bytes)
    }
}

/// A debug probe that reads the log.
pub struct Log {
    control_block: Option<u32>,
    table: Option<&'static Table>,
    decoder: Option<Box<dyn StreamDecoder + Send + Sync>>,
    lines: Vec<String>,
}

impl Log {
    /// A probe that knows the image; one without a log is read as silent.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        // The decoder borrows the table for as long as it lives, and both live as long as the test.
        let table = Table::parse(image.bytes()).ok().flatten();
        let table: Option<&'static Table> = table.map(|table| &*Box::leak(Box::new(table)));
        Self {
            control_block: image.symbol("_SEGGER_RTT"),
            table,
            decoder: table.map(Table::new_stream_decoder),
            lines: Vec::new(),
        }
    }

    /// The lines so far, with the firmware's own time and level.
    #[must_use]
    pub fn lines(&self) -> &[String] {
        &self.lines
    }

    /// Takes what the firmware has logged.
    pub fn drain(&mut self, memory: &mut impl Memory) {
        let (Some(block), Some(decoder)) = (self.control_block, &mut self.decoder) else {
            return;
        };
        let [buffer, size, write, read] =
            [BUFFER, SIZE, WRITE, READ].map(|field| memory.word(block + field));
        // Before its start-up code has run, the block holds what was in memory.
        if read == write || read >= size || write >= size {
            return;
        }
        let mut all = vec![0; size as usize];
        memory.read(buffer, &mut all);
        let (read, end) = (read as usize, write as usize);
        let fresh = if read < end {
            all[read..end].to_vec()
        } else {
            [&all[read..], &all[..end]].concat()
        };
        memory.write_word(block + READ, write);
        decoder.received(&fresh);
        loop {
            match decoder.decode() {
                Ok(frame) => self.lines.push(frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => return,
                Err(DecodeError::Malformed) => {
                    self.lines.push("a line that does not decode".into())
                }
            }
        }
    }

    /// The firmware starts anew: half a line that it had begun will never be finished.
    pub fn restart(&mut self) {
        self.decoder = self.table.map(Table::new_stream_decoder);
    }
}
