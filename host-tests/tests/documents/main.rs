//! What the documents were read anew for, judged on the wire.
//!
//! The rules of these tests are written down from the documents a second time: they read the bytes of the bus themselves and use neither
//! the codecs nor the simulated drives, so that a mistake that both share shows here.

mod servo;
mod stops;
mod trace;
mod wheel;
