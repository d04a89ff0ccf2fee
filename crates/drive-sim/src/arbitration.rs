//! Equal identifiers on the wire at once.
//!
//! Law (Bosch CAN 2.0 B, sections 3.1.1, 4 and 7): identifiers decide arbitration, so two nodes that send the same one at the same instant both go on.
//! If all their bits agree, one frame is on the wire and both have sent it. Otherwise, at the first bit that differs, the nodes that send
//! a recessive bit and see a dominant one have a bit error. If one of them is error-active, its flag destroys the frame for all, and all
//! repeat it at the same next instant: the collision repeats until, 16 errors later, they are error-passive. An error-passive node has a
//! recessive flag that disturbs nobody, so then the node with the dominant bit gets its frame through.

use crate::frame::Frame;
use crate::wire::sof_to_crc_stuffed;

/// A node that sends the identifier that won.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contender {
    /// What it sends.
    pub frame: Frame,
    /// Whether it is error-passive.
    pub is_passive: bool,
}

/// How contenders with equal identifiers came apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Resolution {
    /// Contenders, by index, that saw a bit error but could not disturb the others.
    pub silenced: Vec<usize>,
    /// The bit, counted from 1 at SOF, in which the remaining ones collided; `None` if the rest of them send one and the same frame.
    pub collision_at_bit: Option<u32>,
}

/// Walks the frames of `contenders` bit by bit until they end or collide.
pub fn resolve(contenders: &[Contender]) -> Resolution {
    let mut walks: Vec<_> = contenders
        .iter()
        .map(|contender| sof_to_crc_stuffed(&contender.frame))
        .collect();
    let mut silenced = Vec::new();
    for bit in 1.. {
        let levels: Vec<_> = walks.iter_mut().map(Iterator::next).collect();
        let senders_of = |level| {
            let at_level = (0..contenders.len()).filter(|index| levels[*index] == Some(level));
            at_level
                .filter(|index| !silenced.contains(index))
                .collect::<Vec<usize>>()
        };
        let (dominant, recessive) = (senders_of(false), senders_of(true));
        if dominant.is_empty() && recessive.is_empty() {
            break;
        }
        if dominant.is_empty() || recessive.is_empty() {
            continue;
        }
        if recessive.iter().any(|index| !contenders[*index].is_passive) {
            return Resolution {
                silenced,
                collision_at_bit: Some(bit),
            };
        }
        silenced.extend(recessive);
    }
    Resolution {
        silenced,
        collision_at_bit: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::standard;

    fn resolve_data(data: &[(u8, bool)]) -> Resolution {
        let contender = |&(byte, is_passive)| Contender {
            frame: standard(0x123, &[byte]),
            is_passive,
        };
        resolve(&data.iter().map(contender).collect::<Vec<_>>())
    }

    #[test]
    fn equal_frames_are_one() {
        let one = Resolution {
            silenced: vec![],
            collision_at_bit: None,
        };
        assert_eq!(resolve_data(&[(5, false), (5, false), (5, true)]), one);
    }

    #[test]
    fn active_nodes_collide_in_the_first_bit_that_differs() {
        // 0x123 and DLC 1 give 0 00100100011 000 0001 with one stuff bit behind 00000: SOF to DLC are 20 bits on the wire.
        let first_data_bit = Resolution {
            silenced: vec![],
            collision_at_bit: Some(21),
        };
        assert_eq!(
            resolve_data(&[(0x00, false), (0x80, false)]),
            first_data_bit
        );
        let third_data_bit = Resolution {
            silenced: vec![],
            collision_at_bit: Some(23),
        };
        assert_eq!(resolve_data(&[(0x20, false), (0x00, true)]), third_data_bit);
    }

    #[test]
    fn passive_nodes_give_way_to_the_dominant_bit() {
        assert_eq!(
            resolve_data(&[(0x80, true), (0x00, false)]),
            Resolution {
                silenced: vec![0],
                collision_at_bit: None
            }
        );
        assert_eq!(
            resolve_data(&[(0x01, true), (0x80, true), (0x00, true)]),
            Resolution {
                silenced: vec![1, 0],
                collision_at_bit: None
            }
        );
        // The eighth data bit has one more stuff bit in front of it, behind five dominant data bits.
        assert_eq!(
            resolve_data(&[(0x01, false), (0x80, true), (0x00, true)]),
            Resolution {
                silenced: vec![1],
                collision_at_bit: Some(29)
            }
        );
    }

    #[test]
    fn length_code_collides_too() {
        let contenders = [standard(0x123, &[]), standard(0x123, &[0])].map(|frame| Contender {
            frame,
            is_passive: false,
        });
        assert_eq!(resolve(&contenders).collision_at_bit, Some(20));
    }
}
