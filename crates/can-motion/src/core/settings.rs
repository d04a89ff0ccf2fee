//! What settings of every family must satisfy.

use crate::core::stamp::MOST_AGE_US;

/// A waiting time: its name, the least that works, and what it is.
pub(crate) type Wait = (&'static str, u32, u32);

/// The first of these waiting times that is too short.
pub(crate) fn first_too_short(waits: &[Wait]) -> Option<Wait> {
    let is_too_short = |(_, least, actual): &Wait| actual < least;
    waits.iter().copied().find(is_too_short)
}

/// The first of these waiting times that is longer than points in time are kept: it would end early.
pub(crate) fn first_too_long(waits: &[(&'static str, u32)]) -> Option<(&'static str, u32)> {
    waits.iter().copied().find(|(_, us)| *us > MOST_AGE_US)
}

/// The first address that is not above the one before it.
pub(crate) fn first_out_of_order<A: Copy + PartialOrd>(
    addresses: impl Iterator<Item = A> + Clone,
) -> Option<A> {
    let mut pairs = addresses.clone().zip(addresses.skip(1));
    pairs
        .find(|(lower, upper)| upper <= lower)
        .map(|(_, upper)| upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_wait_below_its_least_is_found() {
        assert_eq!(first_too_short(&[("a", 5, 5), ("b", 0, 0)]), None);
        let two = [("a", 5, 5), ("b", 5, 4), ("c", 5, 3)];
        assert_eq!(first_too_short(&two), Some(("b", 5, 4)));
    }

    #[test]
    fn addresses_rise_and_none_stands_twice() {
        let found = |addresses: &[u8]| first_out_of_order(addresses.iter().copied());
        assert_eq!(found(&[]), None);
        assert_eq!(found(&[1, 2, 9]), None);
        assert_eq!(found(&[1, 3, 3, 2]), Some(3));
        assert_eq!(found(&[1, 3, 2]), Some(2));
    }
}
