//! Texts and bytes have a largest length.

use heapless::{String, Vec};

/// A short text.
pub type Text = String<32>;
/// A piece of the settings.
pub type Chunk = Vec<u8, 128>;
