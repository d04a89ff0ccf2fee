//! The life of axes, played on the public API alone: a family whose drives say what the test wants, a controller of a few lines, and the exact frames,
//! states, events and counters that must come of it. What single facts promise is in `every_fact`; here is what the master makes of them.

mod drive;
mod example;
mod family;
mod rig;

mod ages;
mod commands;
mod faults;
mod groups;
mod many;
mod outlook;
mod own_moves;
mod power;
mod requests;
mod time;
mod together;
mod traffic;
