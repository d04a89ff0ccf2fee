//! Golden vectors of `zlac_sdo.json` and `zlac_misc.json`.

use host_tests::{vectors_dir, zlac_misc, zlac_sdo};

#[test]
fn every_sdo_frame_encodes_and_decodes_or_is_refused() {
    zlac_sdo::check(&vectors_dir()).assert_passed();
}

#[test]
fn every_other_message_encodes_and_decodes_or_is_refused() {
    zlac_misc::check(&vectors_dir()).assert_passed();
}
