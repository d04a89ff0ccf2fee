//! The whole object dictionary of the guide (section 9): 194 rows, in ascending order.
//!
//! ```
//! use zlac8030l::{ObjectAddress, dictionary};
//!
//! let speed = dictionary::find(ObjectAddress::new(0x60FF, 0)).unwrap();
//! assert_eq!((speed.name, speed.min, speed.max, speed.unit), ("target speed", -1000, 1000, "r/min"));
//! assert!(speed.write(1001).is_err());
//! ```

mod communication;
mod entry;
mod manufacturer;
mod profile;

pub use entry::{Access, Default, Entry};

use crate::error::WriteError;
use crate::object::ObjectAddress;
use crate::sdo::SdoRequest;

/// The groups, in ascending order.
const GROUPS: [&[Entry]; 3] = [
    communication::ENTRIES,
    manufacturer::ENTRIES,
    profile::ENTRIES,
];

/// Every object, in ascending order of index and sub-index.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    GROUPS.into_iter().flatten()
}

/// The object at an address; `None` when the guide has none there.
#[must_use]
pub fn find(address: ObjectAddress) -> Option<&'static Entry> {
    GROUPS.iter().find_map(|group| {
        let place = group.binary_search_by_key(&address, |entry| entry.address);
        group.get(place.ok()?)
    })
}

/// The request that writes a value to the object at an address, in the object's width.
///
/// # Errors
/// [`WriteError`] when there is no such object, it is read-only, or the value leaves its range.
pub fn write(address: ObjectAddress, value: i64) -> Result<SdoRequest, WriteError> {
    find(address)
        .ok_or(WriteError::NoSuchObject { address })?
        .write(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_194_rows_are_there_in_order() {
        assert_eq!(entries().count(), 194);
        let addresses = || entries().map(|entry| entry.address);
        assert!(addresses().zip(addresses().skip(1)).all(|(a, b)| a < b));
        for entry in entries() {
            assert_eq!(find(entry.address), Some(entry));
        }
        assert_eq!(find(ObjectAddress::new(0x2024, 0)), None);
    }

    #[test]
    fn ranges_fit_types_and_defaults_fit_ranges() {
        for entry in entries() {
            assert!(entry.min < entry.max, "{}", entry.address);
            for bound in [entry.min, entry.max] {
                assert!(entry.data_type.data(bound).is_some(), "{}", entry.address);
            }
            if let Some(value) = entry.default.of(crate::NodeId::MAX) {
                assert!(entry.check(value).is_ok(), "{}", entry.address);
            }
        }
    }

    #[test]
    fn read_only_and_unknown_objects_are_not_written() {
        let status = ObjectAddress::new(0x6041, 0);
        assert_eq!(
            write(status, 0),
            Err(WriteError::ReadOnly { address: status })
        );
        let unknown = ObjectAddress::new(0x6041, 1);
        assert_eq!(
            write(unknown, 0),
            Err(WriteError::NoSuchObject { address: unknown })
        );
    }
}
