//! What is known when the plan comes.

/// A value that comes later. Before, all of it is zero, so that a static of it takes no place in the flash: `Option` may use another value
/// of the payload for nothing.
#[derive(Debug)]
#[repr(u8)]
pub(crate) enum Late<T> {
    /// It has not come.
    Not = 0,
    /// It has.
    Come(T) = 1,
}

impl<T> Late<T> {
    #[inline]
    pub(crate) const fn get(&self) -> Option<&T> {
        match self {
            Self::Not => None,
            Self::Come(value) => Some(value),
        }
    }

    #[inline]
    pub(crate) const fn get_mut(&mut self) -> Option<&mut T> {
        match self {
            Self::Not => None,
            Self::Come(value) => Some(value),
        }
    }
}
