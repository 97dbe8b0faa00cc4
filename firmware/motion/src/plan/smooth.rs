//! What plans keep for smooth ramps alone. Where none are built in, it takes neither memory nor code.

use super::Order;
use super::goal::SIN_SQUARED;
use super::piece::{Piece, Shape};
use crate::exact::{Q96, Q128};

/// Whether ramps other than linear ones are built in. The moving average is one of linear ramps.
pub(crate) const SMOOTH: bool = SIN_SQUARED || cfg!(feature = "limited-jerk");

/// What linear ramps have in its place.
pub(crate) trait OfLinear: Copy + 'static {
    const OF_LINEAR: &'static Self;
}

impl OfLinear for bool {
    const OF_LINEAR: &'static Self = &false;
}

impl OfLinear for Q96 {
    const OF_LINEAR: &'static Self = &Self::ZERO;
}

impl OfLinear for Q128 {
    const OF_LINEAR: &'static Self = &Self::ZERO;
}

impl OfLinear for Shape {
    const OF_LINEAR: &'static Self = &Self::Cubic(Q128::ZERO);
}

impl OfLinear for Option<Order> {
    const OF_LINEAR: &'static Self = &None;
}

impl OfLinear for Option<Piece> {
    const OF_LINEAR: &'static Self = &None;
}

/// A value that smooth ramps have; without them, that of linear ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Smooth<T>(
    #[cfg(any(feature = "sin-squared", feature = "limited-jerk"))] T,
    #[cfg(not(any(feature = "sin-squared", feature = "limited-jerk")))]
    core::marker::PhantomData<T>,
);

impl<T: OfLinear> Smooth<T> {
    /// What linear ramps have.
    pub(crate) const NONE: Self = Self::new(*T::OF_LINEAR);

    #[inline]
    pub(crate) const fn new(value: T) -> Self {
        #[cfg(any(feature = "sin-squared", feature = "limited-jerk"))]
        return Self(value);
        #[cfg(not(any(feature = "sin-squared", feature = "limited-jerk")))]
        return {
            let _ = value;
            Self(core::marker::PhantomData)
        };
    }

    #[inline]
    pub(crate) const fn get(&self) -> &T {
        #[cfg(any(feature = "sin-squared", feature = "limited-jerk"))]
        return &self.0;
        #[cfg(not(any(feature = "sin-squared", feature = "limited-jerk")))]
        return T::OF_LINEAR;
    }
}
