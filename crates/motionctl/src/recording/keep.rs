//! The seam to what keeps a recording: a file, a page, a view.

use std::io;

use super::item::Item;

/// Something that keeps what it is given.
pub(crate) trait Keep: Send {
    /// Keeps one more item; it may stay in memory until [`Self::flush`].
    ///
    /// # Errors
    /// When nothing can be written any more.
    fn keep(&mut self, item: &Item) -> io::Result<()>;

    /// Brings everything to its place.
    ///
    /// # Errors
    /// As [`Self::keep`].
    fn flush(&mut self) -> io::Result<()>;

    /// Writes what belongs behind the last item.
    ///
    /// # Errors
    /// As [`Self::keep`].
    fn finish(&mut self) -> io::Result<()>;
}
