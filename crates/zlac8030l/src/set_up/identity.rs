//! How a drive is known before anything is written to it.

use super::error::SetUpError;
use super::options::{Firmware, SetUpOptions};
use crate::object::{ObjectAddress, ObjectData, ObjectValue};
use crate::objects;
use crate::typed_object::Object;

/// Something by which the drive is known.
pub(super) struct Identity {
    pub(super) address: ObjectAddress,
    len: u8,
    expected: Option<u32>,
}

impl Identity {
    const fn new<T: ObjectValue>(object: Object<T>, expected: Option<u32>) -> Self {
        Self {
            address: object.address(),
            len: T::DATA_TYPE.bytes(),
            expected,
        }
    }

    pub(super) fn check(&self, data: ObjectData) -> Result<(), SetUpError> {
        let address = self.address;
        match data.raw_of_width(self.len) {
            Err(error) => Err(SetUpError::Width { address, error }),
            Ok(actual) => match self.expected {
                Some(expected) if expected != actual => Err(SetUpError::Identity {
                    address,
                    expected,
                    actual,
                }),
                _ => Ok(()),
            },
        }
    }
}

/// What is read to know the drive (1000h, 1018h), its firmware (2025h), and that it has one axis: 60FFh:00 is one speed of 4 bytes.
pub(super) const fn identity(number: u8, options: SetUpOptions) -> Option<Identity> {
    Some(match number {
        0 => Identity::new(objects::DEVICE_TYPE, Some(0x0004_0192)),
        1 => Identity::new(objects::VENDOR_ID, Some(0x100)),
        2 => Identity::new(objects::PRODUCT_CODE, Some(1)),
        3 => match options.firmware {
            Firmware::Version(version) => {
                Identity::new(objects::SOFTWARE_VERSION, Some(version as u32))
            }
            Firmware::Any => Identity::new(objects::SOFTWARE_VERSION, None),
        },
        4 => Identity::new(objects::TARGET_SPEED, None),
        _ => return None,
    })
}
