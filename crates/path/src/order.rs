//! The smaller and the larger of two numbers.

/// In two instructions: the library's `min` and `max` are calls where the processor has no instruction for them, because of what is no
/// number. Here a number is kept before what is none behind it.
pub(crate) trait Order {
    fn lower(self, other: Self) -> Self;
    fn higher(self, other: Self) -> Self;
}

impl Order for f32 {
    fn lower(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    fn higher(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}
