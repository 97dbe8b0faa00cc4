//! The sections of modular devices.

use super::object::{self, put};
use crate::document::Section;
use crate::model::{Field, Model, Module, ObjectType};

pub(super) fn write<'a>(model: &'a Model, sections: &mut Vec<Section<'a>>) {
    if !model.dynamic_channels.is_empty() {
        let mut section = Section::new("DynamicChannels");
        section.put("NrOfSeg", model.dynamic_channels.len().to_string());
        for (number, channel) in (1..).zip(&model.dynamic_channels) {
            section.put(
                format!("Type{number}"),
                format!("0x{:04X}", channel.data_type),
            );
            if let Some(access) = channel.access {
                section.put(format!("Dir{number}"), access.name());
            }
            let range = format!("0x{:04X}-0x{:04X}", channel.first, channel.last);
            section.put(format!("Range{number}"), range);
            let offset = match channel.difference {
                Some(difference) => format!("{},{difference}", channel.offset),
                None => channel.offset.to_string(),
            };
            section.put(format!("PPOffset{number}"), offset);
        }
        sections.push(section);
    }
    if !model.modules.is_empty() {
        let mut section = Section::new("SupportedModules");
        section.put("NrOfEntries", model.modules.len().to_string());
        sections.push(section);
    }
    if !model.connected.is_empty() {
        let numbers = model.connected.iter().map(u8::to_string);
        sections.push(list("ConnectedModules".into(), numbers));
    }
    for module in &model.modules {
        write_module(module, sections);
    }
}

fn list<'a>(name: String, values: impl Iterator<Item = String>) -> Section<'a> {
    let mut section = Section::new(name);
    section.put("NrOfEntries", "");
    for (number, value) in (1..).zip(values) {
        section.put(format!("{number}"), value);
    }
    let count = (section.keys.len() - 1).to_string();
    if let Some(first) = section.keys.first_mut() {
        first.value = count.into();
    }
    section
}

fn write_module<'a>(module: &'a Module, sections: &mut Vec<Section<'a>>) {
    let number = module.number;
    let mut section = Section::new(format!("M{number}ModuleInfo"));
    section.put("ProductName", &module.product_name);
    section.put("ProductVersion", module.product_version.to_string());
    section.put("ProductRevision", module.product_revision.to_string());
    section.put("OrderCode", &module.order_code);
    section.keys.retain(|key| !key.value.is_empty());
    sections.push(section);
    if !module.comments.is_empty() {
        let mut section = Section::new(format!("M{number}Comments"));
        section.put("Lines", module.comments.len().to_string());
        for (number, line) in (1..).zip(&module.comments) {
            section.put(format!("Line{number}"), line);
        }
        sections.push(section);
    }
    if !module.fixed.is_empty() {
        let indices = module
            .fixed
            .iter()
            .map(|object| format!("0x{:04X}", object.index));
        sections.push(list(format!("M{number}FixedObjects"), indices));
    }
    for fixed in &module.fixed {
        let from = sections.len();
        object::write(fixed, sections);
        for section in sections.iter_mut().skip(from) {
            section.name = format!("M{number}Fixed{}", section.name).into();
        }
    }
    if !module.extensions.is_empty() {
        let indices =
            (module.extensions.iter()).map(|extension| format!("0x{:04X}", extension.index));
        sections.push(list(format!("M{number}SubExtends"), indices));
    }
    for extension in &module.extensions {
        let mut section = Section::new(format!("M{number}SubExt{:04X}", extension.index));
        let entry = &extension.entry;
        object::write_entry(
            (extension.index, None),
            entry,
            ObjectType::Var,
            &mut section,
        );
        put(&mut section, Field::Count, extension.count.to_string());
        let continues = if extension.continues { "1" } else { "0" };
        put(&mut section, Field::ObjExtend, continues.into());
        sections.push(section);
    }
}
