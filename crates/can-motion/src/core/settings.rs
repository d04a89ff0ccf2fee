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
