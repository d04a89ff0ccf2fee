//! Hands the linker the memory map and the linker scripts of the image, and the compiler a configuration other than `src/config.rs`.
//!
//! The arguments are here and not in `.cargo/config.toml` because a `RUSTFLAGS` variable of the user would replace those without
//! a word and link an image without a vector table, and because they would apply to every other crate built for the target.

use std::path::PathBuf;
use std::{env, error, fs};

/// Names a file that is compiled in the place of `src/config.rs`; `cargo fw --config` sets it.
const CONFIG: &str = "MOTION_BOARD_CONFIG";
/// Memory map of each board, by its feature as cargo writes it in the environment. None is called `memory.x` in the folder of the package:
/// the linker looks there first.
const MEMORY_MAPS: [(&str, &str); 2] = [
    ("CARGO_FEATURE_STM32F405", "src/board/stm32f405.x"),
    ("CARGO_FEATURE_STM32G474", "src/board/stm32g474.x"),
];
/// What is put behind the map of a board for the image that keeps settings in its flash.
const OF_LINK: (&str, &str, &str) = (
    "CARGO_FEATURE_LINK",
    MEMORY_MAPS[0].1,
    "src/store/sectors.x",
);

fn main() -> Result<(), Box<dyn error::Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    choose_config()?;
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let chosen: Vec<&str> = MEMORY_MAPS
        .into_iter()
        .filter_map(|(feature, map)| env::var_os(feature).map(|_| map))
        .collect();
    let [map] = chosen[..] else {
        return Err(format!(
            "the image is for exactly one board, its features name {}: use `cargo fw --board`, or `--no-default-features --features <board>`",
            chosen.len()
        )
        .into());
    };
    println!("cargo::rerun-if-changed={map}");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let mut text = fs::read_to_string(map)?;
    let (feature, of_map, more) = OF_LINK;
    println!("cargo::rerun-if-changed={more}");
    if map == of_map && env::var_os(feature).is_some() {
        text += &fs::read_to_string(more)?;
    }
    fs::write(out.join("memory.x"), text)?;
    println!("cargo::rustc-link-search={}", out.display());
    // cortex-m-rt's memory layout, defmt's string table, no page alignment: flash has no pages to map; and functions that are the same, such
    // as the copies of memset for 4 and for 8 bytes, have one place: half a KiB. Nothing here compares the addresses of functions.
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic", "--icf=all"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
    Ok(())
}

fn choose_config() -> Result<(), Box<dyn error::Error>> {
    println!("cargo::rustc-check-cfg=cfg(other_config)");
    println!("cargo::rerun-if-env-changed={CONFIG}");
    let Some(path) = env::var_os(CONFIG) else {
        return Ok(());
    };
    let path = fs::canonicalize(&path)
        .map_err(|reason| format!("{CONFIG}={}: {reason}", path.display()))?;
    println!("cargo::rustc-cfg=other_config");
    println!(
        "cargo::rustc-env=MOTION_BOARD_CONFIG_FILE={}",
        path.display()
    );
    Ok(())
}
