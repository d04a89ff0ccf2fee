//! Golden vectors of `dyn_can_replies.json`.

use host_tests::{dyn_can_replies, vectors_dir};

#[test]
fn every_reply_decodes_to_its_fields_and_back() {
    dyn_can_replies::check(&vectors_dir()).assert_passed();
}
