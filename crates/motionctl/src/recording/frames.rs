//! The frames on the wire with what they mean, in little memory: every text is kept once.

use std::collections::HashMap;
use std::collections::VecDeque;

use super::about::Quantity;
use super::describe::{Describer, Description};
use super::wire_frame::WireFrame;

/// Frames that are kept; older ones go. About half a minute of a full bus, some megabytes of page.
const MOST: usize = 300_000;
/// Texts after which those that no frame needs any more go: at least half of them.
const MOST_TEXTS: usize = 2 * MOST;

/// One attempt on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sighting {
    pub(crate) start_ns: u64,
    /// From the start to the end of the last EOF bit, or of the bit in which the error was seen.
    pub(crate) bits: u32,
    /// Which of the texts.
    pub(crate) text: usize,
}

/// The newest frames of a run.
#[derive(Debug)]
pub(crate) struct Frames {
    describer: Describer,
    sightings: VecDeque<Sighting>,
    /// `p|03C FF 88|to drive 1 ...`: the class by which the strip colours it, the frame, what it says.
    texts: Vec<String>,
    numbers: HashMap<String, usize>,
    forgotten: u64,
}

impl Frames {
    pub(crate) fn new(quantity: Quantity) -> Self {
        Self {
            describer: Describer::new(quantity),
            sightings: VecDeque::new(),
            texts: Vec::new(),
            numbers: HashMap::new(),
            forgotten: 0,
        }
    }

    pub(crate) fn push(&mut self, frame: &WireFrame) {
        let Description { class, text } = self.describer.describe(frame);
        let text = format!("{class}|{}|{text}", frame.frame);
        let text = match self.numbers.get(&text) {
            Some(&number) => number,
            None => {
                self.texts.push(text.clone());
                self.numbers.insert(text, self.texts.len() - 1);
                self.texts.len() - 1
            }
        };
        if self.sightings.len() == MOST {
            self.sightings.pop_front();
            self.forgotten += 1;
        }
        self.sightings.push_back(Sighting {
            start_ns: frame.start_ns,
            bits: frame.bits,
            text,
        });
        if self.texts.len() >= MOST_TEXTS {
            self.forget_texts();
        }
    }

    /// Drops the texts of frames that are not kept any more: positions differ in nearly every reply.
    fn forget_texts(&mut self) {
        let mut places: Vec<Option<usize>> = vec![None; self.texts.len()];
        let mut kept = Vec::new();
        for sighting in &mut self.sightings {
            let place = places.get_mut(sighting.text);
            let Some(place) = place else { continue };
            sighting.text = *place.get_or_insert_with(|| {
                kept.push(core::mem::take(&mut self.texts[sighting.text]));
                kept.len() - 1
            });
        }
        self.texts = kept;
        let numbered = self.texts.iter().cloned().zip(0..);
        self.numbers = numbered.collect();
    }

    pub(crate) fn sightings(&self) -> impl ExactSizeIterator<Item = &Sighting> {
        self.sightings.iter()
    }

    pub(crate) fn texts(&self) -> &[String] {
        &self.texts
    }

    /// Frames that were on the wire before the oldest one that is kept.
    pub(crate) fn forgotten(&self) -> u64 {
        self.forgotten
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_decode::Frame;

    #[test]
    fn what_is_kept_of_an_endless_run_is_limited_and_stays_right() {
        let mut frames = Frames::new(Quantity::Position);
        for number in 0..700_000_u32 {
            // Every reply with another position.
            let bytes = number.to_be_bytes();
            let frame = Frame::new(0x02E, false, &bytes).unwrap();
            frames.push(&WireFrame::ended(
                u64::from(number) * 1_000_000,
                frame,
                Some(false),
                1_000,
            ));
        }
        assert_eq!(frames.sightings().len(), MOST);
        assert_eq!(frames.forgotten(), 400_000);
        assert!(frames.texts().len() < MOST_TEXTS);
        for (sighting, number) in frames.sightings().zip(400_000_u32..) {
            let text = &frames.texts()[sighting.text];
            let [a, b, c, d] = number.to_be_bytes();
            let expected = format!("|02E {a:02X} {b:02X} {c:02X} {d:02X}|");
            assert!(text.contains(&expected), "{text} is not {expected}");
        }
    }
}
