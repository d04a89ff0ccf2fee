//! The files in the folder `interop` are those that the tables of the codecs make.

use std::fs;
use std::path::Path;

use host_tests::field_files::FIELD_FILES;

/// A program, which no table makes; the CI step `wireshark` runs it.
const WRITTEN_BY_HAND: &str = "dyn-can.lua";

#[test]
fn the_files_are_those_that_would_be_written() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../interop");
    for (name, text) in FIELD_FILES {
        let kept = fs::read_to_string(folder.join(name)).unwrap();
        assert!(
            kept == text(),
            "{name}: run `cargo run -p host-tests --bin field-files`"
        );
    }
    assert!(folder.join(WRITTEN_BY_HAND).is_file());
    assert_eq!(fs::read_dir(folder).unwrap().count(), FIELD_FILES.len() + 1);
}
