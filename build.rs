//! Hands the linker the memory map and the linker scripts of the image; does nothing for the host.
//!
//! The arguments are here and not in `.cargo/config.toml` because a `RUSTFLAGS` variable of the user would replace those without
//! a word and link an image without a vector table, and because they would apply to every other crate built for the target.

use std::path::PathBuf;
use std::{env, error, fs};

fn main() -> Result<(), Box<dyn error::Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::copy("memory.x", out.join("memory.x"))?;
    println!("cargo::rustc-link-search={}", out.display());
    // cortex-m-rt's memory layout, defmt's string table, and no page alignment: flash has no pages to map.
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    Ok(())
}
