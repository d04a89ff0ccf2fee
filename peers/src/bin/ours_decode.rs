//! See `peers::ours_decode`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

peers::image!(peers::ours_decode);
