//! A ZLAC8030L as its CANopen guide describes it, as far as a master in velocity mode sees it.

use std::collections::BTreeMap;

use dyn_can::DataFrame;

/// Object, sub-index, bytes, value after power-on.
const OBJECTS: [(u16, u8, u8, u32); 47] = [
    (0x1000, 0, 4, 0x0004_0192),
    (0x1018, 1, 4, 0x100),
    (0x1018, 2, 4, 1),
    (0x1017, 0, 2, 1_000),
    (0x2000, 0, 2, 1_000),
    (0x2001, 0, 2, 0),
    (0x2009, 0, 2, 0),
    (0x200A, 0, 2, 1_000),
    (0x2010, 0, 2, 0),
    (0x2025, 0, 2, 7),
    (0x202F, 5, 2, 1),
    (0x603F, 0, 2, 0),
    (0x6040, 0, 2, 0),
    (0x6041, 0, 2, 0),
    (0x605A, 0, 2, 6),
    (0x605B, 0, 2, 1),
    (0x605C, 0, 2, 1),
    (0x605D, 0, 2, 1),
    (0x6060, 0, 1, 0),
    (0x6081, 0, 4, 120),
    (0x6083, 0, 4, 500),
    (0x6084, 0, 4, 500),
    (0x6085, 0, 4, 10),
    (0x60FF, 0, 4, 0),
    (0x1401, 2, 1, 254),
    (0x1601, 0, 1, 0),
    (0x1601, 1, 4, 0),
    (0x1601, 2, 4, 0),
    (0x1601, 3, 4, 0),
    (0x1601, 4, 4, 0),
    (0x1800, 2, 1, 254),
    (0x1800, 3, 2, 5),
    (0x1800, 5, 2, 0),
    (0x1A00, 0, 1, 0),
    (0x1A00, 1, 4, 0),
    (0x1A00, 2, 4, 0),
    (0x1A00, 3, 4, 0),
    (0x1A00, 4, 4, 0),
    (0x1801, 2, 1, 254),
    (0x1801, 3, 2, 5),
    (0x1801, 5, 2, 0),
    (0x1A01, 0, 1, 0),
    (0x1A01, 1, 4, 0),
    (0x1A01, 2, 4, 0),
    (0x1A01, 3, 4, 0),
    (0x1A01, 4, 4, 0),
    (0x2026, 1, 2, 250),
];

pub(super) const PRE_OPERATIONAL: u8 = 0x7F;
pub(super) const OPERATIONAL: u8 = 0x05;

/// One drive.
#[derive(Debug, Clone)]
pub(super) struct WheelDrive {
    pub(super) node: u16,
    objects: BTreeMap<(u16, u8), (u8, u32)>,
    pub(super) nmt: u8,
    /// Bits 0 to 3 of the status word.
    pub(super) state: u16,
    is_quick_stopped: bool,
    pub(super) fault: u16,
    last_word: u16,
    pub(super) speed_decirpm: i32,
    pub(super) silent_until_us: u64,
    pub(super) beat_us: u64,
    pub(super) feedback_us: u64,
}

impl WheelDrive {
    pub(super) fn new(node: u16) -> Self {
        Self {
            node,
            objects: OBJECTS
                .iter()
                .map(|(index, sub, len, value)| ((*index, *sub), (*len, *value)))
                .collect(),
            nmt: PRE_OPERATIONAL,
            state: 0,
            is_quick_stopped: false,
            fault: 0,
            last_word: 0,
            speed_decirpm: 0,
            silent_until_us: 0,
            beat_us: 0,
            feedback_us: 0,
        }
    }

    fn value(&self, index: u16) -> u32 {
        self.objects.get(&(index, 0)).map_or(0, |(_, value)| *value)
    }

    pub(super) fn heartbeat_us(&self) -> u64 {
        u64::from(self.value(0x1017)) * 1_000
    }

    pub(super) fn status(&self) -> u16 {
        if self.fault != 0 {
            return 0x08;
        }
        self.state | u16::from(!self.is_quick_stopped) << 5
    }

    /// Both PDOs of the drive, where they are mapped.
    pub(super) fn feedback(&self) -> Vec<DataFrame> {
        let mut status = Vec::from(self.status().to_le_bytes());
        status.extend(self.fault.to_le_bytes());
        status.extend(self.speed_decirpm.to_le_bytes());
        let frame = |id, data: &[u8]| DataFrame::new(id | self.node, data).expect("a PDO");
        let is_mapped = self.value(0x1A00) == 3 && self.value(0x1A01) == 2;
        if self.nmt != OPERATIONAL || !is_mapped {
            return Vec::new();
        }
        vec![frame(0x180, &status), frame(0x280, &[0; 6])]
    }

    /// It loses its power stage, and says so.
    pub(super) fn trip(&mut self, fault: u16) -> DataFrame {
        (self.fault, self.state, self.speed_decirpm) = (fault, 0, 0);
        let [low, high] = 0x2310_u16.to_le_bytes();
        DataFrame::new(0x080 | self.node, &[low, high, 1, 0, 0, 0, 0, 0]).expect("a message")
    }

    /// Network management; what it says of itself afterwards.
    pub(super) fn manage(&mut self, command: u8) -> DataFrame {
        match command {
            0x01 => self.nmt = OPERATIONAL,
            0x80 => self.nmt = PRE_OPERATIONAL,
            _ => {}
        }
        self.heartbeat(self.nmt)
    }

    pub(super) fn heartbeat(&self, state: u8) -> DataFrame {
        DataFrame::new(0x700 | self.node, &[state]).expect("a heartbeat")
    }

    /// Control word and target, in the PDO that the master maps.
    pub(super) fn command(&mut self, data: &[u8]) {
        let &[low, high, a, b, c, d] = data else {
            return;
        };
        if self.nmt != OPERATIONAL || self.value(0x1601) != 2 {
            return;
        }
        self.control(u16::from_le_bytes([low, high]));
        let target = i32::from_le_bytes([a, b, c, d]);
        let turns = self.state == 7 && !self.is_quick_stopped;
        self.speed_decirpm = if turns { target * 10 } else { 0 };
    }

    fn control(&mut self, word: u16) {
        let has_edge = word & 0x80 != 0 && self.last_word & 0x80 == 0;
        self.last_word = word;
        if has_edge {
            self.fault = 0;
        }
        if self.fault != 0 || word & 0x80 != 0 {
            return;
        }
        match (word & 0xF, self.state) {
            (0x2, 7) => self.is_quick_stopped = true,
            (0x6, 0 | 3 | 7) => self.state = 1,
            (0x7, 1 | 7) => self.state = 3,
            (0xF, 3) => self.state = 7,
            (0xF, 7) => self.is_quick_stopped = false,
            (0x0 | 0x2, _) => self.state = 0,
            _ => {}
        }
        if self.state != 7 {
            (self.is_quick_stopped, self.speed_decirpm) = (false, 0);
        }
    }

    /// The answer of the object dictionary.
    pub(super) fn transfer(&mut self, data: &[u8]) -> Option<DataFrame> {
        let &[command, low, high, sub, a, b, c, d] = data else {
            return None;
        };
        let index = u16::from_le_bytes([low, high]);
        let answer = |command: u8, value: u32| {
            let [a, b, c, d] = value.to_le_bytes();
            DataFrame::new(0x580 | self.node, &[command, low, high, sub, a, b, c, d]).ok()
        };
        let status = u32::from(self.status());
        let fault = u32::from(self.fault);
        let Some((len, value)) = self.objects.get_mut(&(index, sub)) else {
            return answer(0x80, 0x0602_0000).filter(|_| command != 0x80);
        };
        match command {
            0x40 => {
                let value = match index {
                    0x6041 => status,
                    0x603F => fault,
                    _ => *value,
                };
                let command = 0x43 | (4 - *len) << 2;
                answer(command, value)
            }
            0x80 => None,
            _ => {
                *value = u32::from_le_bytes([a, b, c, d]);
                let word = *value as u16;
                let answer = answer(0x60, 0);
                if index == 0x6040 {
                    self.control(word);
                }
                answer
            }
        }
    }
}
