//! The end of the board: links only if no call of it can panic.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        proofs::board_link::exercise_board();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
