//! Objects that have other values for the time of one command, and get those back that they had.
//!
//! 2010h = 1 comes first, so that nothing reaches the EEPROM: where bringing back fails, a power cycle does it.

use zlac8030l::NodeId;

use super::bus::Bus;
use super::error::HubError;
use super::object::ObjectSetting;
use super::store::{protect, request};

/// What was changed in a drive.
#[derive(Debug)]
pub(super) struct ForNow {
    node: NodeId,
    /// The values before, in the order of the changes.
    before: Vec<ObjectSetting>,
}

impl ForNow {
    /// Nothing is changed yet; from here on no write reaches the EEPROM by itself.
    ///
    /// # Errors
    /// As [`protect`].
    pub(super) fn new(bus: &mut Bus, node: NodeId) -> Result<Self, HubError> {
        protect(bus, node)?;
        Ok(Self {
            node,
            before: Vec::new(),
        })
    }

    /// Writes values and reads them back.
    ///
    /// # Errors
    /// [`HubError::NotTaken`], or the bus's. What was changed until then is brought back by [`Self::bring_back`].
    pub(super) fn set(&mut self, bus: &mut Bus, wanted: &[ObjectSetting]) -> Result<(), HubError> {
        for &setting in wanted {
            let address = setting.entry.address;
            let present = bus.read_number(self.node, address)?;
            if present == setting.value {
                continue;
            }
            if !self.before.iter().any(|old| old.entry == setting.entry) {
                self.before.push(ObjectSetting {
                    value: present,
                    ..setting
                });
            }
            write(bus, self.node, setting)?;
        }
        Ok(())
    }

    /// Writes the values that were there before, all of them whatever happens to one.
    ///
    /// # Errors
    /// [`HubError::NotBack`] with those that are not back.
    pub(super) fn bring_back(self, bus: &mut Bus) -> Result<(), HubError> {
        let mut left = Vec::new();
        let mut first = None;
        for old in self.before.into_iter().rev() {
            if let Err(error) = write(bus, self.node, old) {
                left.push(old);
                first = first.or(Some(error));
            }
        }
        match first {
            None => Ok(()),
            Some(error) => Err(HubError::NotBack {
                node: self.node,
                left,
                error: Box::new(error),
                after: None,
            }),
        }
    }

    /// The end of a command: what it came to, and whether the values are back.
    ///
    /// # Errors
    /// That of the command, or [`HubError::NotBack`] with that of the command behind it.
    pub(super) fn end<T>(self, bus: &mut Bus, done: Result<T, HubError>) -> Result<T, HubError> {
        match (self.bring_back(bus), done) {
            (Ok(()), done) => done,
            (
                Err(HubError::NotBack {
                    node, left, error, ..
                }),
                done,
            ) => Err(HubError::NotBack {
                node,
                left,
                error,
                after: done.err().map(Box::new),
            }),
            (Err(error), _) => Err(error),
        }
    }
}

/// A write that is read back; one that is not confirmed may have arrived.
fn write(bus: &mut Bus, node: NodeId, setting: ObjectSetting) -> Result<(), HubError> {
    match bus.write(node, request(&setting)?) {
        Ok(()) | Err(HubError::WriteInDoubt { .. }) => {}
        Err(error) => return Err(error),
    }
    let address = setting.entry.address;
    let actual = bus.read_number(node, address)?;
    if actual == setting.value {
        return Ok(());
    }
    Err(HubError::NotTaken {
        node,
        address,
        expected: setting.value,
        actual,
    })
}
