//! A walk over everything that can be reached, breadth first, so that a broken promise is shown with the shortest path to it.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};
use std::fmt::Debug;
use std::hash::Hash;

/// A promise that does not hold.
#[derive(Debug)]
pub(crate) struct Broken {
    pub(crate) promise: &'static str,
    /// The inputs that lead there, and the facts before and after the last one.
    pub(crate) path: String,
}

/// Whether a promise holds; the error names it.
pub(crate) type Held = Result<(), &'static str>;

pub(crate) const fn hold(holds: bool, promise: &'static str) -> Held {
    if holds { Ok(()) } else { Err(promise) }
}

/// Everything that can be reached from `starts`, or the first broken promise. `next` is `None` where an input cannot happen.
pub(crate) fn walk<S: Copy + Eq + Hash + Debug, I: Copy + Debug>(
    starts: &[S],
    inputs: &[I],
    next: impl Fn(S, I) -> Option<S>,
    check: impl Fn(S, I, S) -> Held,
) -> Result<Vec<S>, Broken> {
    let mut came_from: HashMap<S, Option<(S, I)>> = starts.iter().map(|&s| (s, None)).collect();
    let mut queue: VecDeque<S> = starts.iter().copied().collect();
    let mut seen = starts.to_vec();
    while let Some(state) = queue.pop_front() {
        for &input in inputs {
            let Some(after) = next(state, input) else {
                continue;
            };
            if let Err(promise) = check(state, input, after) {
                let mut path = vec![input];
                let mut at = state;
                while let Some(Some((before, input))) = came_from.get(&at) {
                    path.push(*input);
                    at = *before;
                }
                path.reverse();
                let path = format!("{path:?}\n      {state:?}\n   -> {after:?}");
                return Err(Broken { promise, path });
            }
            if let Entry::Vacant(place) = came_from.entry(after) {
                place.insert(Some((state, input)));
                queue.push_back(after);
                seen.push(after);
            }
        }
    }
    Ok(seen)
}
