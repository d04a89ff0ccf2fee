//! What would help a plan that was refused: the plan is worked out anew for each change.

use core::fmt;

use can_frame::BitRate;

use crate::text::Text;

/// Changes of one setting each with which a refused plan would be admitted; the number of axes is always one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Remedies {
    /// The most requests in a cycle, fewer than planned.
    pub requests_per_cycle: Option<u8>,
    /// No polls at all.
    pub no_polls: bool,
    /// The lowest bit rate, higher than planned.
    pub bit_rate: Option<BitRate>,
    /// A cycle that is long enough, in microseconds: the planned one times 5/4, 3/2, 2, 3 or 4.
    pub cycle_us: Option<u32>,
    /// How many axes fit, from the first one on.
    pub axes: usize,
}

impl Remedies {
    pub(crate) const NONE: Self = Self {
        requests_per_cycle: None,
        no_polls: false,
        bit_rate: None,
        cycle_us: None,
        axes: 0,
    };

    pub(crate) const fn add_to(&self, text: Text) -> Text {
        let mut text = text.str("it would fit with ");
        let mut separator = "";
        if let Some(requests) = self.requests_per_cycle {
            text = text.str("requests_per_cycle = ").number(requests as u64);
            separator = ", or ";
        }
        if self.no_polls {
            text = text.str(separator).str("no polls");
            separator = ", or ";
        }
        if let Some(bit_rate) = self.bit_rate {
            text = text.str(separator).number(bit_rate.kbit_per_s() as u64);
            text = text.str(" kbit/s");
            separator = ", or ";
        }
        if let Some(cycle_us) = self.cycle_us {
            text = text.str(separator).str("cycle_us = ");
            text = text.number(cycle_us as u64);
            separator = ", or ";
        }
        match self.axes {
            0 if separator.is_empty() => text.str("none of the usual changes"),
            0 => text,
            axes => {
                let text = text.str(separator).str("the first ");
                text.number(axes as u64).str(" axes")
            }
        }
    }
}

impl fmt::Display for Remedies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.add_to(Text::EMPTY).as_str())
    }
}
