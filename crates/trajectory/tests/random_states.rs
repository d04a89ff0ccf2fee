//! 10^5 random states, a class of difficulty each, checked by a judge and against another solver.

mod independent;

use independent::cases::Case;
use independent::judge::{judge, judge_samples};
use independent::optimum::{is_beyond_range, lower_bound, optimum};
use proptest::prelude::*;
use trajectory::Profile;

/// Relative and absolute allowance over the optimum. Profiles are planned with limits that are smaller by 2^-14 and built up within at
/// least 2^-12 cycles, which is what the absolute one is for.
const SLOWER: f64 = 1.01;
const LATER_CYCLES: f64 = 1.0 / 256.0;

fn check(seed: u64) -> Result<(), String> {
    let case = Case::of_seed(seed);
    let profile = match Profile::to_rest(&case.start, case.target, &case.limits) {
        Ok(profile) => profile,
        Err(_) if is_beyond_range(&case) => return Ok(()),
        Err(error) => return Err(error.to_string()),
    };
    judge(&case, &profile)?;
    judge_samples(&case, &profile, 50)?;
    let duration = profile.duration().ticks() as f64 / 4_294_967_296.0;
    let most = optimum(&case);
    if duration < lower_bound(&case) * 0.9999 - LATER_CYCLES {
        return Err(format!("faster than the limits allow: {duration} cycles"));
    }
    match most {
        Some(best) if duration > best * SLOWER + LATER_CYCLES => {
            Err(format!("{duration} cycles, the optimum is {best}"))
        }
        _ => Ok(()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_state_comes_to_rest_within_the_limits_and_in_time(seed in any::<u64>().no_shrink()) {
        if let Err(reason) = check(seed) {
            return Err(TestCaseError::fail(format!("{reason}\n{:#?}", Case::of_seed(seed))));
        }
    }
}

/// Starts that have to be caught at a thousand times the limit of the speed and more, where an acceleration that was planned for the
/// limit alone took up to 1.07 times the optimum.
#[test]
fn a_start_far_above_its_limit_is_caught_with_the_full_acceleration() {
    for seed in [812_275, 108_374_482, 5_188_029, 3_435_797] {
        check(seed).unwrap_or_else(|reason| panic!("seed {seed}: {reason}"));
    }
}
