//! From one format of data sheets to another.

use crate::model::{FileKind, Model};
use crate::report::Report;
use crate::{diff, print, xdd};

/// A format of data sheets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// CiA 306, all devices of a kind.
    Eds,
    /// CiA 306, one configured device.
    Dcf,
    /// CiA 311, all devices of a kind.
    Xdd,
    /// CiA 311, one configured device.
    Xdc,
}

impl Format {
    /// The format of a file with this extension.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "eds" => Self::Eds,
            "dcf" => Self::Dcf,
            "xdd" => Self::Xdd,
            "xdc" => Self::Xdc,
            _ => return None,
        })
    }

    /// Whether it describes one device, which has been given its node-ID.
    pub fn is_of_one_device(self) -> bool {
        matches!(self, Self::Dcf | Self::Xdc)
    }
}

/// What a model is in another format.
#[derive(Clone, Debug)]
pub struct Converted {
    /// The file.
    pub text: String,
    /// What the file means, with what is wrong with it.
    pub report: Report,
    /// What the format cannot say: a line for each difference.
    pub lost: Vec<String>,
}

/// Writes a model in a format; `None` when that is one of a configured device, and the model has neither a node-ID nor a value for
/// one. `file` is the name that the file will have.
pub fn convert(model: &Model, format: Format, file: &str) -> Option<Converted> {
    let mut wanted = model.clone();
    wanted.file_info.file_name = file.into();
    if format.is_of_one_device() {
        let mut entries = wanted.objects.iter().flat_map(|object| &object.entries);
        let has_values = entries.any(|entry| entry.configured.is_some());
        if wanted.commissioning.is_none() && wanted.kind != FileKind::Dcf && !has_values {
            return None;
        }
        wanted.kind = FileKind::Dcf;
    } else {
        wanted.kind = FileKind::Eds;
        for_all_devices(&mut wanted);
    }
    let text = match format {
        Format::Eds | Format::Dcf => print(&wanted),
        Format::Xdd | Format::Xdc => xdd::write(&wanted),
    };
    let report = Report::new(file, &text);
    let lost = diff::diff(model, &report.model);
    let lost = lost.iter().map(ToString::to_string).collect();
    Some(Converted { text, report, lost })
}

/// Takes away what only one device has.
fn for_all_devices(model: &mut Model) {
    model.commissioning = None;
    model.connected.clear();
    let objects = model.types.iter_mut().chain(&mut model.objects);
    for object in objects {
        object.denotation = None;
        for entry in &mut object.entries {
            entry.configured = None;
            entry.denotation = None;
            entry.upload_file = None;
            entry.download_file = None;
        }
    }
}
