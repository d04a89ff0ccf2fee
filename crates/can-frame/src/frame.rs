//! A classic CAN data frame with an 11-bit identifier.

use core::fmt;

use crate::error::FrameError;

/// A data frame: identifier 0 ..= 0x7FF and 0 ..= 8 data bytes.
///
/// The bytes behind the data are zero, so that equal frames compare equal.
// Three words, so that a processor copies it in words, and the data begin at one: controllers take them as words.
#[repr(C, align(4))]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DataFrame {
    data: [u8; 8],
    id: u16,
    /// As wide as the identifier, so that no byte of the words is without a value.
    len: u16,
}

impl DataFrame {
    /// A data frame from its identifier and data.
    ///
    /// # Errors
    /// [`FrameError::Identifier`] beyond 0x7FF, [`FrameError::DataLength`] beyond 8 bytes.
    pub fn new(id: u16, data: &[u8]) -> Result<Self, FrameError> {
        Self::from_parts(u32::from(id), false, false, data)
    }

    /// A data frame from what a CAN controller reports of it.
    ///
    /// # Errors
    /// [`FrameError`] for 29-bit identifiers, remote frames, identifiers beyond 0x7FF and more than 8 bytes.
    pub fn from_parts(
        id: u32,
        extended: bool,
        remote: bool,
        data: &[u8],
    ) -> Result<Self, FrameError> {
        if extended {
            return Err(FrameError::Extended { id });
        }
        if remote {
            return Err(FrameError::Remote { id });
        }
        if id > 0x7FF {
            return Err(FrameError::Identifier { id });
        }
        let mut frame = Self {
            id: id as u16,
            len: data.len() as u16,
            data: [0; 8],
        };
        let Some(destination) = frame.data.get_mut(..data.len()) else {
            return Err(FrameError::DataLength { actual: data.len() });
        };
        destination.copy_from_slice(data);
        Ok(frame)
    }

    /// A data frame from its fields, for a codec whose types hold them in range.
    ///
    /// Of `id` the lower 11 bits count, and a `len` above 8 is 8. The bytes of `data` behind `len` must be zero, or the frame does not
    /// equal one that was received.
    #[must_use]
    pub const fn from_fields(id: u16, len: u8, data: [u8; 8]) -> Self {
        Self {
            id: id & 0x7FF,
            len: if len > 8 { 8 } else { len as u16 },
            data,
        }
    }

    /// The identifier, 0 ..= 0x7FF.
    #[must_use]
    pub const fn id(&self) -> u16 {
        self.id
    }

    /// The number of data bytes, 0 ..= 8.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a frame is not a collection")]
    pub const fn len(&self) -> u8 {
        self.len as u8
    }

    /// The data bytes.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&self.data)
    }

    /// All eight bytes, zero behind the data.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; 8] {
        &self.data
    }
}

impl AsRef<Self> for DataFrame {
    fn as_ref(&self) -> &Self {
        self
    }
}

impl fmt::Display for DataFrame {
    /// `03C#FF88`, the form of candump logs.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:03X}#", self.id)?;
        self.data()
            .iter()
            .try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl fmt::Debug for DataFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DataFrame({self})")
    }
}

#[cfg(feature = "embedded-can")]
mod embedded {
    use super::DataFrame;
    use crate::error::FrameError;
    use embedded_can::{Frame, Id};

    impl DataFrame {
        /// A data frame from any `embedded_can` frame.
        ///
        /// # Errors
        /// [`FrameError`] for 29-bit identifiers and remote frames.
        pub fn from_can(frame: &impl Frame) -> Result<Self, FrameError> {
            let (id, extended) = match frame.id() {
                Id::Standard(id) => (u32::from(id.as_raw()), false),
                Id::Extended(id) => (id.as_raw(), true),
            };
            Self::from_parts(id, extended, frame.is_remote_frame(), frame.data())
        }

        /// The same frame in another `embedded_can` frame type; `None` only when that type refuses 8 bytes or fewer.
        #[must_use]
        pub fn to_can<F: Frame>(&self) -> Option<F> {
            F::new(embedded_can::StandardId::new(self.id())?, self.data())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_drives_do_not_know_is_refused() {
        use FrameError::{DataLength, Extended, Identifier, Remote};
        assert_eq!(
            DataFrame::from_parts(0x121, true, false, &[0]),
            Err(Extended { id: 0x121 })
        );
        assert_eq!(
            DataFrame::from_parts(0x0E9, false, true, &[]),
            Err(Remote { id: 0x0E9 })
        );
        // Drive 64 would need identifier 0x800.
        assert_eq!(DataFrame::new(0x800, &[]), Err(Identifier { id: 0x800 }));
        assert_eq!(
            DataFrame::new(0x7FF, &[0; 9]),
            Err(DataLength { actual: 9 })
        );
    }

    #[test]
    fn fields_make_the_frame_that_their_bytes_make() {
        let composed = DataFrame::from_fields(0x03C, 2, [0xFF, 0x88, 0, 0, 0, 0, 0, 0]);
        assert_eq!(Ok(composed), DataFrame::new(0x03C, &[0xFF, 0x88]));
        assert_eq!((composed.len(), composed.data()), (2, &[0xFF, 0x88][..]));
        let out_of_range = DataFrame::from_fields(0x801, 9, [1; 8]);
        assert_eq!(Ok(out_of_range), DataFrame::new(0x001, &[1; 8]));
    }

    #[test]
    fn prints_like_a_candump_log() {
        let frame = DataFrame::new(0x03C, &[0xFF, 0x88]).unwrap();
        assert_eq!(std::format!("{frame}"), "03C#FF88");
        assert_eq!(std::format!("{frame:?}"), "DataFrame(03C#FF88)");
        assert_eq!(
            std::format!("{}", DataFrame::new(0x7E9, &[]).unwrap()),
            "7E9#"
        );
    }

    #[cfg(feature = "embedded-can")]
    #[test]
    fn a_frame_of_a_driver_is_the_same_frame() {
        use embedded_can::{ExtendedId, Frame, Id, StandardId};

        /// A frame as drivers have it.
        #[derive(Debug, PartialEq, Eq)]
        struct OfDriver {
            id: Id,
            is_remote: bool,
            data: std::vec::Vec<u8>,
        }
        impl Frame for OfDriver {
            fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
                Some(Self {
                    id: id.into(),
                    is_remote: false,
                    data: data.into(),
                })
            }
            fn new_remote(id: impl Into<Id>, _: usize) -> Option<Self> {
                Self::new(id, &[]).map(|frame| Self {
                    is_remote: true,
                    ..frame
                })
            }
            fn is_extended(&self) -> bool {
                matches!(self.id, Id::Extended(_))
            }
            fn is_remote_frame(&self) -> bool {
                self.is_remote
            }
            fn id(&self) -> Id {
                self.id
            }
            fn dlc(&self) -> usize {
                self.data.len()
            }
            fn data(&self) -> &[u8] {
                &self.data
            }
        }
        let id = StandardId::new(0x03C).unwrap();
        let of_driver = OfDriver::new(id, &[0xFF, 0x88]).unwrap();
        let frame = DataFrame::new(0x03C, &[0xFF, 0x88]).unwrap();
        assert_eq!(DataFrame::from_can(&of_driver), Ok(frame));
        assert_eq!(frame.to_can(), Some(of_driver));
        let long = OfDriver::new(ExtendedId::new(0x03C).unwrap(), &[]).unwrap();
        let refused = FrameError::Extended { id: 0x03C };
        assert_eq!(DataFrame::from_can(&long), Err(refused));
        let remote = OfDriver::new_remote(id, 0).unwrap();
        let refused = FrameError::Remote { id: 0x03C };
        assert_eq!(DataFrame::from_can(&remote), Err(refused));
    }
}
