//! Messages that can be built in a `const`, where `core::fmt` does not run.

const CAPACITY: usize = 320;

/// Up to 320 bytes of ASCII; what does not fit is left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Text {
    bytes: [u8; CAPACITY],
    len: usize,
}

impl Text {
    pub(crate) const EMPTY: Self = Self {
        bytes: [b' '; CAPACITY],
        len: 0,
    };

    const fn byte(mut self, byte: u8) -> Self {
        if let Some((_, free)) = self.bytes.split_at_mut_checked(self.len)
            && let Some(next) = free.first_mut()
        {
            *next = byte;
            self.len += 1;
        }
        self
    }

    pub(crate) const fn str(mut self, text: &str) -> Self {
        let mut rest = text.as_bytes();
        while let Some((byte, behind)) = rest.split_first() {
            self = self.byte(*byte);
            rest = behind;
        }
        self
    }

    pub(crate) const fn number(self, number: u64) -> Self {
        self.digits::<10>(number)
    }

    pub(crate) const fn hex(self, number: u64) -> Self {
        self.str("0x").digits::<16>(number)
    }

    const fn digits<const BASE: u64>(mut self, number: u64) -> Self {
        let mut place = 1;
        while let Some(higher) = number.checked_div(place)
            && higher >= BASE
        {
            place *= BASE;
        }
        // Behind the last digit the place is 0.
        while let Some(higher) = number.checked_div(place) {
            self = self.byte(match (higher % BASE) as u8 {
                digit @ 0..10 => b'0' + digit,
                digit => b'A' + digit - 10,
            });
            place /= BASE;
        }
        self
    }

    pub(crate) const fn as_str(&self) -> &str {
        if let Some((text, _)) = self.bytes.split_at_checked(self.len)
            && let Ok(text) = core::str::from_utf8(text)
        {
            return text;
        }
        // Cannot be: only ASCII goes in, byte by byte.
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_text() {
        let text = Text::EMPTY
            .str("a ")
            .number(0)
            .str(",")
            .number(1_090)
            .str(" ")
            .hex(0x3F0);
        assert_eq!(text.as_str(), "a 0,1090 0x3F0");
    }

    #[test]
    fn too_long_a_text_ends_early() {
        let long = core::str::from_utf8(&[b'x'; 400]).unwrap();
        assert_eq!(Text::EMPTY.str(long).number(7).as_str().len(), 320);
    }
}
