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
pub(crate) struct Smooth<T>([T; SMOOTH as usize]);

impl<T: OfLinear> Smooth<T> {
    #[inline]
    pub(crate) const fn new(value: T) -> Self {
        Self([value; SMOOTH as usize])
    }

    #[inline]
    pub(crate) const fn get(&self) -> &T {
        match self.0.as_slice() {
            [value, ..] => value,
            [] => T::OF_LINEAR,
        }
    }
}
