//! Golden vectors of `dyn_units.json`.

use host_tests::{dyn_units, vectors_dir};

#[test]
fn every_unit_formula_gives_its_number() {
    dyn_units::check(&vectors_dir()).assert_passed();
}
