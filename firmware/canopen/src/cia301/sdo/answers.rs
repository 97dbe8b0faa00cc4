//! Answers of one server that wait for the bus.

/// A client has one request in flight. A second one, because the client has given up on the first, has its place as well.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answers {
    places: [[u8; 8]; 2],
    count: u8,
}

impl Answers {
    pub(super) const fn new() -> Self {
        Self {
            places: [[0; 8]; 2],
            count: 0,
        }
    }

    /// Whether nothing waits.
    #[inline]
    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether there is no room. A request is not to be executed then.
    #[inline]
    pub(super) const fn is_full(&self) -> bool {
        self.count >= 2
    }

    /// Adds the newest. There is room, as a request is not executed without.
    #[inline]
    pub(super) fn push(&mut self, answer: [u8; 8]) {
        if let Some(place) = self.places.get_mut(usize::from(self.count)) {
            *place = answer;
            self.count = self.count.wrapping_add(1);
        }
    }

    /// Takes the oldest.
    #[inline]
    pub(super) const fn pop(&mut self) -> Option<[u8; 8]> {
        if self.count == 0 {
            return None;
        }
        let [first, second] = &mut self.places;
        let answer = *first;
        self.count = self.count.wrapping_sub(1);
        if self.count != 0 {
            *first = *second;
        }
        Some(answer)
    }

    pub(super) const fn clear(&mut self) {
        self.count = 0;
    }
}
