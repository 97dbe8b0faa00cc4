//! Where things stand in their file.

use std::collections::BTreeMap;

use crate::source::Span;

/// The keys of an object and of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the standard's own")]
#[repr(u8)]
pub enum Field {
    ParameterName,
    ObjectType,
    DataType,
    AccessType,
    PdoMapping,
    LowLimit,
    HighLimit,
    DefaultValue,
    ObjFlags,
    SubNumber,
    CompactSubObj,
    ParameterValue,
    Denotation,
    UploadFile,
    DownloadFile,
    ParamRefd,
    Count,
    ObjExtend,
}

impl Field {
    /// All of them, in the order in which they are written.
    pub const ALL: [Self; 18] = [
        Self::ParameterName,
        Self::Denotation,
        Self::ObjectType,
        Self::SubNumber,
        Self::DataType,
        Self::AccessType,
        Self::LowLimit,
        Self::HighLimit,
        Self::DefaultValue,
        Self::PdoMapping,
        Self::ObjFlags,
        Self::CompactSubObj,
        Self::ParameterValue,
        Self::UploadFile,
        Self::DownloadFile,
        Self::ParamRefd,
        Self::Count,
        Self::ObjExtend,
    ];

    /// The key as CiA 306 spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ParameterName => "ParameterName",
            Self::ObjectType => "ObjectType",
            Self::DataType => "DataType",
            Self::AccessType => "AccessType",
            Self::PdoMapping => "PDOMapping",
            Self::LowLimit => "LowLimit",
            Self::HighLimit => "HighLimit",
            Self::DefaultValue => "DefaultValue",
            Self::ObjFlags => "ObjFlags",
            Self::SubNumber => "SubNumber",
            Self::CompactSubObj => "CompactSubObj",
            Self::ParameterValue => "ParameterValue",
            Self::Denotation => "Denotation",
            Self::UploadFile => "UploadFile",
            Self::DownloadFile => "DownloadFile",
            Self::ParamRefd => "ParamRefd",
            Self::Count => "Count",
            Self::ObjExtend => "ObjExtend",
        }
    }

    /// Whether it describes one configured device.
    pub(crate) fn is_of_dcf(self) -> bool {
        matches!(
            self,
            Self::ParameterValue
                | Self::Denotation
                | Self::UploadFile
                | Self::DownloadFile
                | Self::ParamRefd
        )
    }

    /// Whether it says how a module extends an object.
    pub(crate) fn is_of_module(self) -> bool {
        matches!(self, Self::Count | Self::ObjExtend)
    }

    /// The key with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|field| field.name().eq_ignore_ascii_case(name))
    }
}

/// Where a section stands, and the values of its keys. All places are equal: they say nothing about what is meant.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// The name of the section.
    pub section: Span,
    fields: Vec<(Field, Span)>,
}

impl Places {
    /// A section.
    pub(crate) fn new(section: Span) -> Self {
        Self {
            section,
            fields: Vec::new(),
        }
    }

    pub(crate) fn put(&mut self, field: Field, span: Span) {
        self.fields.push((field, span));
    }

    /// Whether the key is there.
    pub fn has(&self, field: Field) -> bool {
        self.fields.iter().any(|(own, _)| *own == field)
    }

    /// The value of a key; the section where the key is not there.
    pub fn of(&self, field: Field) -> Span {
        let found = self.fields.iter().find(|(own, _)| *own == field);
        found.map_or(self.section, |(_, span)| *span)
    }
}

impl PartialEq for Places {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Places {}

/// Where a section stands whose keys are no [`Field`], and the values of its keys. Equal to all others, as [`Places`] are.
#[derive(Clone, Debug, Default)]
pub struct KeyPlaces {
    /// The name of the section.
    pub section: Span,
    /// By the key in lower case.
    keys: BTreeMap<String, Span>,
}

impl KeyPlaces {
    /// A section and its keys.
    pub(crate) fn new<'a>(section: Span, keys: impl Iterator<Item = (&'a str, Span)>) -> Self {
        let keys = keys.map(|(name, span)| (name.to_ascii_lowercase(), span));
        Self {
            section,
            keys: keys.collect(),
        }
    }

    /// The value of a key; the section where the key is not there.
    pub fn of(&self, key: &str) -> Span {
        let found = self.keys.get(&key.to_ascii_lowercase());
        found.copied().unwrap_or(self.section)
    }
}

impl PartialEq for KeyPlaces {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for KeyPlaces {}
