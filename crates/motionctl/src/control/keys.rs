//! Keys of the terminal of a motion on a real bus. Ctrl-C and Ctrl-Z stay what they are.

use std::io::{self, IsTerminal};
use std::sync::mpsc::Sender;
use std::time::Duration;

use super::Wish;
use crate::set_points::Order;
use crate::system::Keyboard;

/// What the keys are, in a line.
pub(crate) const HELP: &str =
    "keys: space pause, + - speed, 1 back to 100 %, s stop on the path, Ctrl-C slow down and end";
/// How often is looked whether this program is still in the foreground.
const LOOK: Duration = Duration::from_millis(200);

/// The terminal gives single keys as long as this is held.
#[derive(Debug)]
pub(crate) struct Keys {
    _keyboard: Keyboard,
}

impl Keys {
    /// Takes the keys; `None` where nobody sits in front of standard input.
    ///
    /// # Errors
    /// When the terminal cannot be set up.
    pub(crate) fn open(wishes: Sender<Wish>) -> io::Result<Option<Self>> {
        if !io::stdin().is_terminal() {
            return Ok(None);
        }
        let Some(keyboard) = Keyboard::take()? else {
            return Ok(None);
        };
        std::thread::Builder::new().spawn(move || listen(&wishes))?;
        Ok(Some(Self {
            _keyboard: keyboard,
        }))
    }
}

fn listen(wishes: &Sender<Wish>) {
    while let Ok(key) = Keyboard::key(LOOK) {
        if let Some(wish) = key.and_then(wish)
            && wishes.send(wish).is_err()
        {
            return;
        }
    }
}

/// The meaning of a key.
pub(crate) fn wish(key: u8) -> Option<Wish> {
    Some(match key {
        b' ' | b'p' => Wish::TogglePause,
        b'+' | b'=' => Wish::Faster,
        b'-' => Wish::Slower,
        b'1' => Wish::Order(Order::Override(100)),
        b's' | b'q' => Wish::Order(Order::Stop),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_named_in_their_help() {
        assert_eq!(wish(b' '), Some(Wish::TogglePause));
        assert_eq!(wish(b's'), Some(Wish::Order(Order::Stop)));
        assert_eq!(wish(b'1'), Some(Wish::Order(Order::Override(100))));
        assert_eq!(wish(b'x'), None);
        for word in ["space pause", "+ - speed", "1 back", "s stop"] {
            assert!(HELP.contains(word));
        }
    }
}
