//! Generates the codec of `drive.dbc`, and hands the linker the memory map of the default board and the linker script of the start-up code.

use std::path::PathBuf;
use std::{env, error, fs};

use dbc_codegen::Config;

const DESCRIPTION: &str = "drive.dbc";

fn main() -> Result<(), Box<dyn error::Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../src/board/stm32f405.x");
    println!("cargo::rerun-if-changed={DESCRIPTION}");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let content = fs::read_to_string(DESCRIPTION)?;
    Config::builder()
        .dbc_name(DESCRIPTION)
        .dbc_content(&content)
        .build()
        .write_to_file(out.join("messages.rs"))?;
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    fs::copy("../src/board/stm32f405.x", out.join("memory.x"))?;
    println!("cargo::rustc-link-search={}", out.display());
    for argument in ["-Tlink.x", "--nmagic"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    Ok(())
}
