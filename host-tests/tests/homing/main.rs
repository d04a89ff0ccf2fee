//! The homing of one axis through the unmodified master, on the virtual bus, with a simulated drive that has end stops and a switch.
//!
//! The places of stops and switch are counts from where the shaft stood at power-on, which neither master nor homing ever see: a test
//! compares what was found with the simulator's own figures.

mod faults;
mod refusals;
mod stage;
mod stop;
mod switch;
