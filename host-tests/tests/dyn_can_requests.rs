//! Golden vectors of `dyn_can_requests.json`.

use host_tests::{dyn_can_requests, vectors_dir};

#[test]
fn every_request_encodes_to_its_frame_and_back() {
    dyn_can_requests::check(&vectors_dir()).assert_passed();
}
