//! What CiA 301 and CiA 402 say about their objects: kind, types, access, sub-indices.

pub(crate) mod check;
mod communication;
mod drive;

use std::ops::RangeInclusive;

use crate::data_type::DataType;
use crate::model::{Access, Model, ObjectType};
use crate::rules::drive::on_first_axis;
use ObjectType::{Array, Record, Var};

/// An object, or a range of objects that are alike.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) indices: RangeInclusive<u16>,
    pub(super) kind: ObjectType,
    /// Its values by sub-index; those that are not here are not in the standard.
    pub(super) subs: &'static [Sub],
}

/// One value of an object, or values that are alike.
#[derive(Debug)]
pub(super) struct Sub {
    pub(super) subs: RangeInclusive<u8>,
    /// `None` where the standard leaves the type open.
    pub(super) data_type: Option<DataType>,
    pub(super) access: Rights,
    /// Whether the first of them has to be there with its object.
    pub(super) is_needed: bool,
}

/// Who may do what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rights {
    /// Never written: `ro` or `const`.
    Read,
    /// Written; read too, or not.
    Write,
    /// Devices may choose.
    Any,
}

impl Rights {
    pub(super) fn allow(self, access: Access) -> bool {
        match self {
            Self::Read => !access.is_writable(),
            Self::Write => access.is_writable(),
            Self::Any => true,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Read => "ro or const",
            Self::Write => "rw, rww, rwr or wo",
            Self::Any => "anything",
        }
    }
}

impl Known {
    /// What the standard says about `sub`; sub-index 0 of an object with sub-indices is the same everywhere.
    pub(super) fn sub(&self, sub: u8) -> Option<&Sub> {
        self.subs.iter().find(|known| known.subs.contains(&sub))
    }
}

const fn one(data_type: DataType, access: Rights) -> Sub {
    Sub {
        subs: 0..=0,
        data_type: Some(data_type),
        access,
        is_needed: true,
    }
}

const fn needed(sub: u8, data_type: DataType, access: Rights) -> Sub {
    Sub {
        subs: sub..=sub,
        data_type: Some(data_type),
        access,
        is_needed: true,
    }
}

const fn optional(sub: u8, data_type: DataType, access: Rights) -> Sub {
    Sub {
        subs: sub..=sub,
        data_type: Some(data_type),
        access,
        is_needed: false,
    }
}

const fn elements(first: u8, last: u8, data_type: DataType, access: Rights) -> Sub {
    Sub {
        subs: first..=last,
        data_type: Some(data_type),
        access,
        is_needed: true,
    }
}

const fn open(first: u8, last: u8) -> Sub {
    Sub {
        subs: first..=last,
        data_type: None,
        access: Rights::Any,
        is_needed: false,
    }
}

const fn var(index: u16, sub: &'static [Sub]) -> Known {
    Known {
        indices: index..=index,
        kind: Var,
        subs: sub,
    }
}

const fn array(index: u16, subs: &'static [Sub]) -> Known {
    Known {
        indices: index..=index,
        kind: Array,
        subs,
    }
}

const fn record(first: u16, last: u16, subs: &'static [Sub]) -> Known {
    Known {
        indices: first..=last,
        kind: Record,
        subs,
    }
}

/// What the standards say about an object of this device: the name of the standard, and the object. Those of CiA 402 are known
/// on devices that claim its profile, on every axis.
pub(super) fn of(model: &Model, index: u16) -> Option<(&'static str, &'static Known)> {
    let (standard, table, index) = match index {
        0x1000..=0x1FFF => ("CiA 301", communication::OBJECTS, index),
        _ => ("CiA 402", drive::OBJECTS, on_first_axis(model, index)?),
    };
    let at = table.partition_point(|known| *known.indices.end() < index);
    let known = table.get(at)?;
    known.indices.contains(&index).then_some((standard, known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_sorted() {
        for table in [communication::OBJECTS, drive::OBJECTS] {
            for pair in table.windows(2) {
                let [before, after] = pair else { panic!() };
                assert!(before.indices.end() < after.indices.start(), "{after:?}");
            }
        }
    }
}
