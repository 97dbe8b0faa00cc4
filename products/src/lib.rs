//! The drives on the market that this firmware stands in for, one module each, made from the folder of the same name: its data sheet,
//! its binding. `docs/products.md` walks through making one.
//!
//! A host asks for a product by its name and gets the type of its dictionary ([`with`]); an image is built with one data sheet.
#![no_std]
#![forbid(unsafe_code)]

use cia402::Behaves;

/// What there is to know of a product without its dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Product {
    /// The name of its folder.
    pub name: &'static str,
    /// The name that its data sheet gives it.
    pub title: &'static str,
    /// Its data sheet, an EDS.
    pub data_sheet: &'static str,
    /// The ready axis of its virtual drive, if its binding names one.
    pub axis: Option<&'static str>,
}

/// Does something with a dictionary that is chosen by name.
pub trait Visitor {
    /// What comes out.
    type Output;

    /// Does it.
    fn visit<D>(self) -> Self::Output
    where
        D: Behaves + Default + core::fmt::Debug + 'static;
}

include!(concat!(env!("OUT_DIR"), "/products.rs"));

/// The compact drive, `eds/compact.eds`.
pub mod compact {
    include!(concat!(env!("OUT_DIR"), "/compact.rs"));
}

pub mod hooks;
