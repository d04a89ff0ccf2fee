//! Both ends of CANopen as lines of text, so that programs in other languages can judge them.
//!
//! A line such as `604#4064600000000000` is a frame, in either direction. Any other line in is a command, and is answered by
//! lines that begin with `!`, of which the last one is `!done`; a command that is not understood is answered with `!error`.

pub mod client;
pub mod dictionary;
pub mod drive;

use zlac8030l::DataFrame;

use crate::frame_fields::HexBytes;

/// A line as a frame; `None` when it is a command.
pub fn frame(line: &str) -> Option<DataFrame> {
    let (id, data) = line.split_once('#')?;
    let id = u16::from_str_radix(id, 16).ok()?;
    DataFrame::new(id, &HexBytes::parse(data)?.0).ok()
}

/// A number in hexadecimal digits.
fn hex<T: TryFrom<u32>>(text: &str) -> Option<T> {
    u32::from_str_radix(text, 16).ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_told_from_a_command() {
        let boot_up = DataFrame::new(0x704, &[0]).ok();
        assert_eq!(frame("704#00"), boot_up);
        assert_eq!(frame("read 6064 00"), None);
        assert_eq!(frame("800#00"), None);
    }
}
