//! Must not link: an index that may lie outside, as a panic that nobody meant would.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    const CHOICES: [u8; 3] = [1, 2, 3];
    loop {
        proofs::opaque::consume(CHOICES[proofs::opaque::word() as usize]);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
