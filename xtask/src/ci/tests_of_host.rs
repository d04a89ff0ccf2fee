//! The tests of the host.

use std::thread::available_parallelism;

use super::place::Place;
use crate::error::Error;

/// The serial client's front end for UARTs and the settings as a file are features that nothing else turns on; the peers are built for
/// their table only.
const LINES: [&str; 4] = [
    "test",
    "test -p dyn-serial --all-features",
    "test -p board-settings --all-features",
    "test -p peers",
];

/// Runs every test.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    // The tests in real time wait for most of their time: one more than there are processors, which leaves each its time.
    let threads = available_parallelism().map_or(2, |processors| processors.get() + 1);
    let threads = threads.to_string();
    for line in LINES {
        place.cargo_with(line, &[("RUST_TEST_THREADS", &threads)])?;
    }
    Ok(Vec::new())
}
