//! The boards. Each is one file with its clocks, pins, bit rate and interrupts; the application sees only [`Board`] and [`init`].

mod stm32f405;

pub(crate) use stm32f405::{Board, StatusLed, init};
