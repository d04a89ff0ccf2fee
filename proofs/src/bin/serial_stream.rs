//! Encoding of serial requests and decoding of the stream, alone: shows how much flash they take.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        proofs::serial::encode_and_decode_stream();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
