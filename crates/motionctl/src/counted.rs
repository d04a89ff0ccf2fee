//! A number of things, in words.

use core::fmt;

/// `1 frame`, `2 frames`: a number with the noun that fits it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counted<N> {
    number: N,
    one: &'static str,
    more: &'static str,
}

/// A number with the singular and the plural of a noun.
pub(crate) const fn counted<N>(number: N, one: &'static str, more: &'static str) -> Counted<N> {
    Counted { number, one, more }
}

impl<N: fmt::Display + PartialEq + From<u8>> fmt::Display for Counted<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noun = if self.number == N::from(1) {
            self.one
        } else {
            self.more
        };
        write!(f, "{} {noun}", self.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one_and_all_others_are_more() {
        let text = |number: u64| counted(number, "axis", "axes").to_string();
        assert_eq!(
            [0, 1, 2, 21].map(text),
            ["0 axes", "1 axis", "2 axes", "21 axes"]
        );
        assert_eq!(counted(1.0, "turn", "turns").to_string(), "1 turn");
        assert_eq!(counted(0.25, "turn", "turns").to_string(), "0.25 turns");
    }
}
