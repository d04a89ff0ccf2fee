//! A few places without an order: nothing is moved when one becomes free, so no `memmove` is needed (1.6 KB with `Vec::remove`).

#[derive(Debug)]
pub(super) struct Slots<T, const N: usize>([Option<T>; N]);

impl<T, const N: usize> Slots<T, N> {
    pub(super) const fn new() -> Self {
        Self([const { None }; N])
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.0.iter().flatten()
    }

    /// Whether there was room for it.
    pub(super) fn put(&mut self, value: T) -> bool {
        let free = self.0.iter_mut().find(|place| place.is_none());
        free.map(|place| *place = Some(value)).is_some()
    }

    /// What is in a place.
    pub(super) fn get(&self, place: usize) -> Option<T>
    where
        T: Copy,
    {
        self.0.get(place).copied().flatten()
    }

    pub(super) fn clear(&mut self, place: usize) {
        if let Some(place) = self.0.get_mut(place) {
            *place = None;
        }
    }

    /// Takes one out.
    pub(super) fn take(&mut self, is_it: impl Fn(&T) -> bool) -> Option<T> {
        self.0
            .iter_mut()
            .find_map(|place| place.take_if(|value| is_it(value)))
    }
}
