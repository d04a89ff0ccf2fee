//! Finding and appending records.

use crate::flash::{Area, Flash, Reading};
use crate::head::Head;

/// Bytes that are read or programmed at a time: whole units of 4 and of 8 bytes.
const PIECE: usize = 64;
/// Erased.
const BLANK: u8 = 0xFF;

/// Why a record cannot be read or stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StoreError<E> {
    /// It has more bytes than a record may have.
    #[error("a record has at most {expected} bytes, got {actual}")]
    TooLong {
        /// The most.
        expected: usize,
        /// Bytes given.
        actual: usize,
    },
    /// There is less room than the record has bytes.
    #[error("the record needs room for {expected} bytes, got {actual}")]
    Room {
        /// Bytes of the record.
        expected: usize,
        /// Bytes of the room.
        actual: usize,
    },
    /// No slot takes what is programmed: the flash is worn.
    #[error("the flash does not keep what is programmed: replace the chip")]
    Worn,
    /// The driver.
    #[error("the flash: {0}")]
    Flash(E),
}

type Result<T, F> = core::result::Result<T, StoreError<<F as Flash>::Error>>;

/// The place of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slot {
    area: Area,
    number: usize,
}

/// A record that is whole.
#[derive(Debug, Clone, Copy)]
struct Found {
    slot: Slot,
    head: Head,
}

/// Records of at most `MOST` bytes.
#[derive(Debug)]
pub struct Store<F, const MOST: usize> {
    slots: Slots<F>,
}

impl<F: Flash, const MOST: usize> Store<F, MOST> {
    /// Slots of an area: as many older records are kept at least, while the flash is sound.
    pub const SLOTS: usize = Slots::<F>::in_area(MOST);

    /// The records of a flash. Nothing is read yet.
    pub const fn new(flash: F) -> Self {
        const {
            assert!(F::UNIT == 4 || F::UNIT == 8, "a unit has 4 or 8 bytes");
            assert!(Self::SLOTS > 0, "an area must have room for a record");
        }
        let slots = Slots {
            flash,
            most: MOST,
            in_area: Self::SLOTS,
        };
        Self { slots }
    }

    /// The flash.
    pub const fn flash(&mut self) -> &mut F {
        &mut self.slots.flash
    }

    /// A record: 0 is the latest, 1 the one before it. `None` where there is none.
    ///
    /// # Errors
    /// Of the driver, or when the record does not fit the room.
    pub fn read<'a>(&mut self, index: usize, room: &'a mut [u8]) -> Result<Option<&'a [u8]>, F> {
        self.slots.read(index, room)
    }

    /// Hands over every whole record with its number, in the order of their places: one look at the flash for all.
    ///
    /// # Errors
    /// Of the driver.
    pub fn for_each(&mut self, each: impl FnMut(u32, &[u8])) -> Result<(), F> {
        self.slots.for_each(&mut [0; MOST], each)
    }

    /// The number of the latest record; 0 where there is none.
    ///
    /// # Errors
    /// Of the driver.
    pub fn sequence(&mut self) -> Result<u32, F> {
        let newest = self.slots.newest(u32::MAX)?;
        Ok(newest.map_or(0, |found| found.head.sequence))
    }

    /// Whether the next record needs an erase before it, which takes long.
    ///
    /// # Errors
    /// Of the driver.
    pub fn is_full(&mut self) -> Result<bool, F> {
        match self.slots.newest(u32::MAX)? {
            Some(found) => Ok(self.slots.blank_behind(found.slot)?.is_none()),
            None => Ok(true),
        }
    }

    /// Appends a record. Until it returns, the one before it or this one is the latest after a cut of the supply; then it is this one.
    ///
    /// # Errors
    /// When it is too long, the flash is worn, or of the driver. The latest record is the one before then.
    pub fn append(&mut self, data: &[u8]) -> Result<(), F> {
        self.slots.append(data)
    }
}

/// The work of a [`Store`]. The length of its records is a value, so that stores of different records share the code.
#[derive(Debug)]
struct Slots<F> {
    flash: F,
    /// Bytes of the longest record.
    most: usize,
    /// Slots in an area: divided once, where it cannot fail.
    in_area: usize,
}

impl<F: Flash> Slots<F> {
    /// Bytes of a slot: the head, and the data in whole units.
    const fn bytes(most: usize) -> usize {
        Head::BYTES + most.next_multiple_of(F::UNIT)
    }

    const fn in_area(most: usize) -> usize {
        F::AREA_BYTES / Self::bytes(most)
    }

    fn read<'a>(&mut self, index: usize, room: &'a mut [u8]) -> Result<Option<&'a [u8]>, F> {
        let mut found = self.newest(u32::MAX)?;
        for _ in 0..index {
            let Some(newer) = found else {
                return Ok(None);
            };
            found = self.newest(newer.head.sequence)?;
        }
        let Some(Found { slot, head }) = found else {
            return Ok(None);
        };
        let (expected, actual) = (head.length as usize, room.len());
        let bytes = room
            .get_mut(..expected)
            .ok_or(StoreError::Room { expected, actual })?;
        let offset = self.offset(slot) + Head::BYTES;
        self.flash
            .read(slot.area, offset, bytes)
            .map_err(StoreError::Flash)?;
        Ok(Some(bytes))
    }

    fn for_each(&mut self, room: &mut [u8], mut each: impl FnMut(u32, &[u8])) -> Result<(), F> {
        for slot in self.all() {
            let Some(head) = self.head(slot)? else {
                continue;
            };
            let Some(bytes) = room.get_mut(..head.length as usize) else {
                continue;
            };
            if self.is_whole(slot, head)? {
                let offset = self.offset(slot) + Head::BYTES;
                self.flash
                    .read(slot.area, offset, bytes)
                    .map_err(StoreError::Flash)?;
                each(head.sequence, bytes);
            }
        }
        Ok(())
    }

    fn append(&mut self, data: &[u8]) -> Result<(), F> {
        if data.len() > self.most {
            return Err(StoreError::TooLong {
                expected: self.most,
                actual: data.len(),
            });
        }
        let newest = self.newest(u32::MAX)?;
        let sequence = newest.map_or(1, |found| found.head.sequence.saturating_add(1));
        let mut behind = newest.map(|found| found.slot);
        while let Some(last) = behind {
            let blank = self.blank_behind(last)?;
            if let Some(slot) = blank
                && self.program(slot, sequence, data)?
            {
                return Ok(());
            }
            behind = blank;
        }
        // The area with the latest record stays as it is.
        let area = newest.map_or(Area::First, |found| found.slot.area.other());
        self.flash.erase(area).map_err(StoreError::Flash)?;
        for number in 0..self.in_area {
            let slot = Slot { area, number };
            if self.is_blank(slot)? && self.program(slot, sequence, data)? {
                return Ok(());
            }
        }
        Err(StoreError::Worn)
    }

    const fn offset(&self, slot: Slot) -> usize {
        slot.number * Self::bytes(self.most)
    }

    /// Every slot.
    fn all(&self) -> impl Iterator<Item = Slot> + use<F> {
        let slots = self.in_area;
        let in_area = move |area| (0..slots).map(move |number| Slot { area, number });
        Area::BOTH.into_iter().flat_map(in_area)
    }

    /// The whole record with the highest sequence number below a bound.
    fn newest(&mut self, bound: u32) -> Result<Option<Found>, F> {
        let mut newest: Option<Found> = None;
        for slot in self.all() {
            let head = self.head(slot)?;
            let least = newest.map_or(0, |found| found.head.sequence);
            let Some(head) = head.filter(|head| head.sequence > least && head.sequence < bound)
            else {
                continue;
            };
            if self.is_whole(slot, head)? {
                newest = Some(Found { slot, head });
            }
        }
        Ok(newest)
    }

    /// The head of a slot, if it can be one.
    fn head(&mut self, slot: Slot) -> Result<Option<Head>, F> {
        let mut bytes = [0; Head::BYTES];
        let reading = self
            .flash
            .read(slot.area, self.offset(slot), &mut bytes)
            .map_err(StoreError::Flash)?;
        let head = Head::of_bytes(&bytes);
        let is_head = reading == Reading::Good && head.length as usize <= self.most;
        Ok(is_head.then_some(head))
    }

    fn is_whole(&mut self, slot: Slot, head: Head) -> Result<bool, F> {
        let mut digest = Head::begin(head.sequence, head.length);
        let start = self.offset(slot) + Head::BYTES;
        let is_readable = self.for_each_piece(slot.area, start, head.length as usize, |piece| {
            digest.update(piece);
            true
        })?;
        Ok(is_readable && digest.finalize() == head.checksum)
    }

    fn is_blank(&mut self, slot: Slot) -> Result<bool, F> {
        self.for_each_piece(
            slot.area,
            self.offset(slot),
            Self::bytes(self.most),
            |piece| piece.iter().all(|byte| *byte == BLANK),
        )
    }

    /// The first blank slot behind another one, in the same area.
    fn blank_behind(&mut self, slot: Slot) -> Result<Option<Slot>, F> {
        for number in slot.number + 1..self.in_area {
            let next = Slot { number, ..slot };
            if self.is_blank(next)? {
                return Ok(Some(next));
            }
        }
        Ok(None)
    }

    /// Hands over the bytes piece by piece; false as soon as one is unreadable or `each` says so.
    fn for_each_piece(
        &mut self,
        area: Area,
        start: usize,
        length: usize,
        mut each: impl FnMut(&[u8]) -> bool,
    ) -> Result<bool, F> {
        let mut piece = [0; PIECE];
        for offset in (0..length).step_by(PIECE) {
            let size = (length - offset).min(PIECE);
            let bytes = piece.get_mut(..size).unwrap_or_default();
            let reading = self
                .flash
                .read(area, start + offset, bytes)
                .map_err(StoreError::Flash)?;
            if reading == Reading::Unreadable || !each(bytes) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Programs a record, the head last; false when the slot does not keep it.
    fn program(&mut self, slot: Slot, sequence: u32, data: &[u8]) -> Result<bool, F> {
        let mut digest = Head::begin(sequence, data.len() as u32);
        digest.update(data);
        let head = Head {
            sequence,
            length: data.len() as u32,
            checksum: digest.finalize(),
        };
        let start = self.offset(slot);
        for (bytes, number) in data.chunks(PIECE).zip(0..) {
            let mut piece = [BLANK; PIECE];
            for (to, from) in piece.iter_mut().zip(bytes) {
                *to = *from;
            }
            let units = bytes.len().next_multiple_of(F::UNIT);
            let offset = start + Head::BYTES + number * PIECE;
            self.flash
                .program(slot.area, offset, piece.get(..units).unwrap_or_default())
                .map_err(StoreError::Flash)?;
        }
        self.flash
            .program(slot.area, start, &head.to_bytes())
            .map_err(StoreError::Flash)?;
        let kept = self.head(slot)? == Some(head);
        Ok(kept && self.is_whole(slot, head)?)
    }
}
