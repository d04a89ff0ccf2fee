//! Every call of the program crate: links only if none of them can panic.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        proofs::program::exercise();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
