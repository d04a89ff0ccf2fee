//! What shall be set up: single objects, and PDOs as a whole.

use crate::node::PdoNumber;
use crate::object::{ObjectAddress, ObjectData, ObjectValue};
use crate::pdo::{PdoDirection, PdoMapping, PdoObjects};
use crate::typed_object::Object;

/// A value that an object shall have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Setting {
    pub(super) address: ObjectAddress,
    pub(super) data: ObjectData,
}

impl Setting {
    /// A value of a typed object.
    #[must_use]
    pub fn new<T: ObjectValue>(object: Object<T>, value: T) -> Self {
        Self {
            address: object.address(),
            data: value.to_data(),
        }
    }
}

/// How one PDO shall be mapped and sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PdoSetUp {
    /// From the drive or to it.
    pub direction: PdoDirection,
    /// Which of the four.
    pub number: PdoNumber,
    /// Its objects; empty switches the PDO off.
    pub mapping: PdoMapping,
    /// Transmission type; `None` leaves it.
    pub transmission_type: Option<u8>,
    /// Inhibit time in units of the drive (Z11); `None` leaves it.
    pub inhibit_time: Option<u16>,
    /// Event timer in units of the drive (Z11); `None` leaves it.
    pub event_timer: Option<u16>,
}

impl PdoSetUp {
    const fn objects(&self) -> PdoObjects {
        PdoObjects::new(self.direction, self.number)
    }

    /// The settings in the order in which they are written; the count is the last one and makes the PDO valid.
    fn settings(&self) -> impl Iterator<Item = Setting> {
        let objects = self.objects();
        let count = self.mapping.entries().count() as u8;
        let entries = (1..).zip(self.mapping.entries());
        let entries =
            entries.map(move |(sub, entry)| Setting::new(objects.entry(sub), entry.to_word()));
        let kind = self
            .transmission_type
            .map(|value| Setting::new(objects.transmission_type(), value));
        let inhibit = self
            .inhibit_time
            .map(|value| Setting::new(objects.inhibit_time(), value));
        let timer = self
            .event_timer
            .map(|value| Setting::new(objects.event_timer(), value));
        entries
            .chain(kind)
            .chain(inhibit)
            .chain(timer)
            .chain([Setting::new(objects.count(), count)])
    }
}

/// Something to be set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SetUpStep {
    /// One object.
    Value(Setting),
    /// One object that must have a value already; it is never written.
    Expect(Setting),
    /// One PDO; the drive must be pre-operational.
    Pdo(PdoSetUp),
}

impl SetUpStep {
    pub(super) fn setting(&self, place: u8) -> Option<Setting> {
        match self {
            Self::Value(setting) | Self::Expect(setting) => (place == 0).then_some(*setting),
            Self::Pdo(pdo) => pdo.settings().nth(usize::from(place)),
        }
    }

    /// What must be 0 while the settings are written.
    pub(super) const fn gate(&self) -> Option<Object<u8>> {
        match self {
            Self::Value(_) | Self::Expect(_) => None,
            Self::Pdo(pdo) => Some(pdo.objects().count()),
        }
    }
}
