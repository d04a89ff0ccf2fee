//! Trapezoids in whole counts: one step a cycle, with integers alone.
//!
//! A [`Profile`](crate::Profile) costs thousands of instructions when it is planned and hundreds when it is sampled. What a master
//! computes anew for every axis in every cycle must cost less: a [`RampDown`] stops a group on the line that it moves along, and a
//! [`Lag`] leads an axis that has fallen behind back to its moving set-point. Both keep the limit of the acceleration, not one of the
//! jerk.
//!
//! ```
//! use trajectory::whole_counts::RampDown;
//!
//! // Two axes at 1000 and -250 counts per cycle, which may change by 20 and by 10 counts per cycle, in each cycle.
//! let cycles = RampDown::cycles_to_stop(1_000, 20).max(RampDown::cycles_to_stop(-250, 10));
//! assert_eq!(cycles, 50);
//! let mut axes = [RampDown::new(0, 1_000, cycles), RampDown::new(7_000, -250, cycles)];
//! assert_eq!(axes.map(|axis| axis.end()), [24_500, 875]);
//! for _ in 0..cycles {
//!     let [x, y] = axes.each_mut().map(|axis| {
//!         axis.advance();
//!         axis.set_point()
//!     });
//!     assert!((x + 4 * (y - 7_000)).abs() <= 4);
//! }
//! assert_eq!(axes.map(|axis| axis.set_point()), [24_500, 875]);
//! ```

mod lag;
mod ramp_down;

pub use lag::{FRACTION, Lag, Step, StepLimits};
pub use ramp_down::RampDown;
