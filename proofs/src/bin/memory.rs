//! How much memory a master takes on the target: statics of its size, to be read from the symbols of the image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
mod image {
    use core::mem::size_of;

    use can_motion::ServoMaster;

    #[used]
    #[unsafe(no_mangle)]
    static MASTER_OF_2: [u8; size_of::<ServoMaster<2>>()] = [0; size_of::<ServoMaster<2>>()];
    #[used]
    #[unsafe(no_mangle)]
    static MASTER_OF_8: [u8; size_of::<ServoMaster<8>>()] = [0; size_of::<ServoMaster<8>>()];
    #[used]
    #[unsafe(no_mangle)]
    static MASTER_OF_14: [u8; size_of::<ServoMaster<14>>()] = [0; size_of::<ServoMaster<14>>()];

    #[cortex_m_rt::entry]
    fn main() -> ! {
        loop {
            proofs::opaque::consume((&MASTER_OF_2, &MASTER_OF_8, &MASTER_OF_14));
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", proofs::HOST_MESSAGE);
}
