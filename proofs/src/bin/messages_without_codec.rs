//! What the image of the same name with the codec has beside it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        proofs::codec::messages_without_codec();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
