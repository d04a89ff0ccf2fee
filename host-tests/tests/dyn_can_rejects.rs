//! Golden vectors of `dyn_can_rejects.json`.

use host_tests::{dyn_can_rejects, vectors_dir};

#[test]
fn everything_forbidden_is_refused_for_the_right_reason() {
    dyn_can_rejects::check(&vectors_dir()).assert_passed();
}
