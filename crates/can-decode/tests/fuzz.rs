//! Damaged logs of every format: no panic, bounded memory, and an error of one line for what cannot be read.
//!
//! `cargo run --release -p can-decode --example fuzz` is the long run.

mod damage;

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// A decoder with its statistics takes less than 1 MB; what a log adds to it does not grow with its length.
const MOST_MEGABYTES: f32 = 4.0;

// One test alone: the allocator counts for the whole process.
#[test]
fn damaged_logs_are_read_or_refused_in_bounded_memory() {
    let (mut frames, mut errors) = (0, 0);
    for seed in 0..5_000 {
        let (log, stamps) = damage::damaged(seed);
        let tally = damage::run(&log, stamps)
            .unwrap_or_else(|fault| panic!("seed {seed}: {fault}\n{log:?}"));
        frames += tally.frames;
        errors += tally.errors;
    }
    // Logs that are all refused would test the refusals alone.
    assert!(
        frames > 2_500 && errors > 2_500,
        "{frames} frames, {errors} errors"
    );
    assert!(
        ALLOCATOR.peak_usage_as_mb() < MOST_MEGABYTES,
        "{} MB",
        ALLOCATOR.peak_usage_as_mb()
    );
    // A long log takes no more than a short one.
    let long = "(1.000000) can0 029#\nnoise\n".repeat(100_000);
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage_as_mb();
    damage::run(&long, None).unwrap();
    let grown = ALLOCATOR.peak_usage_as_mb() - before;
    assert!(grown < MOST_MEGABYTES, "{grown} MB");
}
