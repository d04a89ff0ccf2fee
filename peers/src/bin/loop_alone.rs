//! See `peers::loop_alone`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

peers::image!(peers::loop_alone);
