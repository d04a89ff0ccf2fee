//! Calls of the whole public interface with inputs that the compiler can know nothing about.
//!
//! The images in `src/bin` make these calls and are linked without a panic handler. A branch that could panic for any
//! input would need the handler, and the image would not link. So an image that links cannot panic, whatever comes from
//! the bus. `cargo xtask proofs` links them for the target and prints what they take of its memory.
//!
//! Nothing here is meant to make sense as a program, and the images are never run.
#![no_std]

pub mod board_link;
pub mod codec;
pub mod commissioning;
pub mod diff_drive;
mod fake_can;
pub mod family;
pub mod homing;
pub mod hub_motors;
pub mod master;
pub mod opaque;
pub mod path;
pub mod program;
pub mod serial;
pub mod text;
pub mod trajectory;

/// What the images print where they are built for the host.
pub const HOST_MESSAGE: &str =
    "this image is for the target, where it must link and is not run: cargo xtask proofs";
