//! The boards. Each is one file with its clocks, pins, bit timing and interrupts; the application sees what `init` returns.

mod stm32f405;

pub(crate) use stm32f405::{StatusLed, init};
