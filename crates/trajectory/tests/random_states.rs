//! 10^5 random states, a class of difficulty each, checked by a judge and against another solver.

mod independent;

use independent::cases::Case;
use independent::judge::{judge, judge_samples};
use independent::optimum::{is_beyond_range, later_cycles, lower_bound, optimum, slower};
use proptest::prelude::*;
use trajectory::Profile;

fn check(seed: u64) -> Result<(), String> {
    let case = Case::of_seed(seed);
    let profile = match Profile::to_rest(&case.start, case.target, &case.limits) {
        Ok(profile) => profile,
        Err(_) if is_beyond_range(&case) => return Ok(()),
        Err(error) => return Err(error.to_string()),
    };
    judge(&case, &profile)?;
    judge_samples(&case, &profile, 50)?;
    let later = later_cycles(&case);
    let duration = profile.duration().ticks() as f64 / 4_294_967_296.0;
    let most = optimum(&case);
    if duration < lower_bound(&case) * 0.9999 - later {
        return Err(format!("faster than the limits allow: {duration} cycles"));
    }
    match most {
        Some(best) if duration > best * slower(&case) + later => {
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
