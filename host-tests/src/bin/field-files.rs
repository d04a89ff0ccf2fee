//! Writes the files that other tools of the field open into the folder `interop`.

use std::path::Path;
use std::process::ExitCode;

use host_tests::field_files::FIELD_FILES;

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../interop");
    for (name, text) in FIELD_FILES {
        let path = folder.join(name);
        if let Err(reason) = std::fs::write(&path, text()) {
            eprintln!("error: {}: {reason}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
