//! The bus plan. So far: how long frames are on the wire; the analysis of whole cycles is not here yet.

pub mod wire;
mod worst_case;
#[cfg(test)]
mod worst_case_search;
