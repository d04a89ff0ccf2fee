//! plan
pub mod wire;
mod worst_case;
#[cfg(test)]
mod worst_case_search;
