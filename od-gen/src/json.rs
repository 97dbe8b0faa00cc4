//! The dictionary for other programs, in JSON.

use serde_json::{Value, json};

use crate::data_type::DataType;
use crate::model::{DefaultValue, Entry, Limit, Model, Object, StorageGroup};
use crate::print::value;

/// The objects with everything that is known of their values. Numbers are numbers, an OCTET_STRING is its bytes in hexadecimal, and
/// a default with `adds_node_id` is without the node-ID; it is null where the
/// file states none.
pub fn json(model: &Model) -> String {
    let device = &model.device;
    let whole = json!({
        "vendor_name": device.vendor_name,
        "product_name": device.product_name,
        "bit_rates": device.bit_rates,
        "node_id": model.commissioning.as_ref().map(|node| node.node_id),
        "objects": [],
    });
    // One object at a time: thousands of them as values would take a hundred times their text.
    let objects = model.objects.iter().map(|own| indented(&object(own)));
    let objects = objects.collect::<Vec<_>>().join(",\n");
    let objects = match objects.is_empty() {
        true => "[]".into(),
        false => format!("[\n{objects}\n  ]"),
    };
    let whole = format!("{whole:#}\n");
    whole.replacen("\"objects\": []", &format!("\"objects\": {objects}"), 1)
}

/// An element of the list of objects, as it stands in the whole.
fn indented(value: &Value) -> String {
    let text = format!("{value:#}");
    let lines = text.lines().map(|line| format!("    {line}"));
    lines.collect::<Vec<_>>().join("\n")
}

fn object(object: &Object) -> Value {
    json!({
        "index": object.index,
        "name": object.name,
        "object_type": object.object_type.name(),
        "entries": object.entries.iter().map(entry).collect::<Vec<_>>(),
    })
}

fn entry(entry: &Entry) -> Value {
    json!({
        "sub": entry.sub,
        "name": entry.name,
        "data_type": entry.data_type.name(),
        "data_type_code": entry.data_type.code(),
        "access": entry.access.name(),
        "pdo_mapping": entry.pdo_mapping,
        "low_limit": entry.low_limit.map(limit),
        "high_limit": entry.high_limit.map(limit),
        "default": entry.default.as_ref().map(|value| default(value, entry.data_type)),
        "adds_node_id": entry.adds_node_id(),
        "configured": entry.configured.as_ref().map(|value| default(value, entry.data_type)),
        "size": entry.size,
        "storage": entry.storage.map(StorageGroup::name),
        "unit": entry.unit(),
    })
}

fn limit(limit: Limit) -> Value {
    match limit {
        Limit::Integer(value) => integer(value),
        Limit::NodeId(_) => value::limit(limit, DataType::Unsigned32).into(),
        Limit::Real(value) => value.into(),
    }
}

fn default(default: &DefaultValue, data_type: DataType) -> Value {
    match default {
        DefaultValue::Number { value, .. } => integer(*value),
        DefaultValue::Real(value) => (*value).into(),
        DefaultValue::Text(_) => value::value(default, data_type).into(),
    }
}

/// No type has numbers of more than 64 bits.
fn integer(value: i128) -> Value {
    match (i64::try_from(value), u64::try_from(value)) {
        (Ok(value), _) => value.into(),
        (_, Ok(value)) => value.into(),
        _ => Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::parse;

    #[test]
    fn the_text_is_that_of_the_whole_as_one_value() {
        let text = include_str!("../tests/data/every.dcf");
        let written = json(&parse("every.dcf", text).unwrap());
        let value: Value = serde_json::from_str(&written).unwrap();
        assert_eq!(written, format!("{value:#}\n"));
        let empty = json(&Model::default());
        assert!(empty.contains("\"objects\": [],"), "{empty}");
    }

    #[test]
    fn every_type_is_written_as_it_is() {
        let text = include_str!("../tests/data/every.dcf");
        let model = parse("every.dcf", text).unwrap();
        let value: Value = serde_json::from_str(&json(&model)).unwrap();
        let objects = value["objects"].as_array().unwrap();
        let entry = |index: u16| {
            let found = objects.iter().find(|object| object["index"] == index);
            &found.unwrap()["entries"][0]
        };
        assert_eq!(entry(0x201B)["default"], u64::MAX);
        assert_eq!(entry(0x2002)["default"], -128);
        assert_eq!(entry(0x2008)["default"], 1.5);
        assert_eq!(entry(0x2008)["low_limit"], -1500.0);
        assert_eq!(entry(0x2009)["default"], "pan");
        assert_eq!(entry(0x2009)["configured"], "frying pan");
        assert_eq!(entry(0x200A)["default"], "00 0A");
        assert_eq!(entry(0x200B)["default"], "süß");
        assert_eq!(entry(0x1014)["adds_node_id"], true);
        assert_eq!(entry(0x1014)["default"], 0x80);
        assert_eq!(entry(0x2013)["storage"], "application");
        assert_eq!(entry(0x200F)["size"], 4096);
        assert_eq!(entry(0x2005)["data_type_code"], 5);
        assert_eq!(value["node_id"], 17);
        assert_eq!(entry(0x1000)["default"], Value::Null, "0 is not stated");
    }
}
