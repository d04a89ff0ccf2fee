//! Objects whose type is known while compiling, with the requests that read and write them.

use core::marker::PhantomData;

use crate::object::{ObjectAddress, ObjectValue};
use crate::sdo::SdoRequest;

/// An object whose type is known while compiling, so that it is always written in the dictionary's width.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Object<T> {
    address: ObjectAddress,
    value: PhantomData<fn(T) -> T>,
}

impl<T> Clone for Object<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Object<T> {}

impl<T: ObjectValue> Object<T> {
    pub(crate) const fn new(index: u16, sub: u8) -> Self {
        Self {
            address: ObjectAddress::new(index, sub),
            value: PhantomData,
        }
    }

    /// Index and sub-index.
    #[must_use]
    pub const fn address(self) -> ObjectAddress {
        self.address
    }

    /// The request that reads it.
    #[must_use]
    pub const fn read(self) -> SdoRequest {
        SdoRequest::Read(self.address)
    }

    /// The request that writes it.
    #[must_use]
    pub fn write(self, value: T) -> SdoRequest {
        SdoRequest::Write(self.address, value.to_data())
    }
}
