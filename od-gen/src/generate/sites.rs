//! The objects that stand for a parameter of the drive.

use cia402_parameters::{Description, PROFILE};

use super::layout::{Layout, Place, Row};
use crate::bind::{self, Binding, Bindings};

/// An object that stands for a parameter.
#[derive(Debug)]
pub(super) struct Site<'a> {
    pub(super) row: &'a Row<'a>,
    /// How the numbers relate; `None` for the object of CiA 402 that has the drive's own numbers.
    pub(super) binding: Option<&'a Binding>,
    /// Whether a write to it changes the parameter.
    pub(super) is_taken: bool,
    /// Whether it follows the parameter.
    pub(super) is_shown: bool,
}

impl Site<'_> {
    /// The module that converts its numbers.
    pub(super) fn module(&self) -> Option<String> {
        let (index, sub) = self.key();
        self.binding.map(|_| format!("binding_{index:04x}_{sub:x}"))
    }

    /// Index and sub-index.
    pub(super) fn key(&self) -> (u16, u8) {
        (self.row.object.index, self.row.entry.sub)
    }

    /// Whether it is the parameter's home.
    pub(super) fn is_home_of(&self, parameter: &Description) -> bool {
        self.key() == parameter.home
    }

    /// Whether it is the parameter's home in CiA 402.
    pub(super) fn is_in_profile(&self, parameter: &Description) -> bool {
        self.is_home_of(parameter) && parameter.home.0 >= PROFILE
    }

    /// What its default means to the drive.
    pub(super) fn default(&self) -> i64 {
        let number = self.row.entry.default_number().unwrap_or_default();
        let number = i64::try_from(number).unwrap_or_default();
        let meaning = self
            .binding
            .and_then(|binding| binding.meaning.to_parameter(number));
        meaning.unwrap_or(number)
    }
}

/// The objects of a parameter, first the one that the drive reads.
pub(super) fn sites<'a>(
    layout: &'a Layout<'a>,
    bindings: &'a Bindings,
    parameter: &Description,
) -> Vec<Site<'a>> {
    let own = bindings
        .rows
        .iter()
        .filter(|binding| binding.parameter == parameter);
    let mut sites: Vec<Site<'_>> = own
        .filter_map(|binding| {
            Some(Site {
                row: layout.row(binding.index, binding.sub)?,
                binding: Some(binding),
                is_taken: binding.is_taken,
                is_shown: binding.is_shown,
            })
        })
        .collect();
    let (index, sub) = parameter.home;
    let is_bound = sites.iter().any(|site| site.is_home_of(parameter));
    let row = layout.row(index, sub);
    let row = row.filter(|row| {
        bind::is_home(row.entry, parameter) && !is_bound && !bindings.is_foreign(index)
    });
    if let Some(row) = row {
        sites.push(Site {
            row,
            binding: None,
            is_taken: row.entry.access.is_writable(),
            is_shown: matches!(row.place, Place::Ram(_)),
        });
    }
    // Stable: equals stay in the order of the file. An object in flash follows nothing, so it comes last unless it is alone.
    sites.sort_by_key(|site| {
        let is_fixed = !matches!(site.row.place, Place::Ram(_));
        (is_fixed, !site.is_home_of(parameter), !site.is_taken)
    });
    sites
}
