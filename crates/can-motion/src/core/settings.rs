//! What settings of every family must satisfy.

/// A waiting time: its name, the least that works, and what it is.
pub(crate) type Wait = (&'static str, u32, u32);

/// The first of these waiting times that is too short.
pub(crate) fn first_too_short(waits: &[Wait]) -> Option<Wait> {
    let is_too_short = |(_, least, actual): &Wait| actual < least;
    waits.iter().copied().find(is_too_short)
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
    fn the_first_waiting_time_that_is_too_short_is_found() {
        let waits = |second| [("a", 5, 5), ("b", 5, second), ("c", 5, 1)];
        assert_eq!(first_too_short(&waits(4)), Some(("b", 5, 4)));
        assert_eq!(first_too_short(&waits(6)), Some(("c", 5, 1)));
        assert_eq!(first_too_short(&waits(9)[..2]), None);
    }

    #[test]
    fn addresses_ascend() {
        let first = |addresses: [u8; 4]| first_out_of_order(addresses.into_iter());
        assert_eq!(first([1, 2, 3, 9]), None);
        assert_eq!(first([1, 3, 2, 1]), Some(2));
        assert_eq!(first([1, 3, 4, 4]), Some(4));
    }
}
