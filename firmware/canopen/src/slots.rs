//! The places of a service, as many as a device has: arrays whose length a service does not know by name.

use core::fmt::Debug;

/// The places of a service, one for each of what it serves: `[T; N]`.
pub trait Slots<T>: AsRef<[T]> + AsMut<[T]> + Debug + Unused {}

/// What a place is before anything uses it.
pub trait Unused: Sized {
    /// Not in use.
    const UNUSED: Self;
}

impl<T: Unused, const N: usize> Unused for [T; N] {
    const UNUSED: Self = [const { T::UNUSED }; N];
}

impl Unused for u8 {
    const UNUSED: Self = 0;
}

impl<T: Unused + Debug, const N: usize> Slots<T> for [T; N] {}
