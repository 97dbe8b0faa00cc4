//! CANopenObject and CANopenSubObject.

use roxmltree::Node;

use super::text::one_line;
use super::{Reader, as_it_is, find, hexadecimal, is};
use crate::data_type::DataType;
use crate::document::{Comment, Key, Section};
use crate::model::Access;

/// Keys of an object or of a value, as attributes of CANopenObject and CANopenSubObject.
pub(super) const ATTRIBUTES: [(&str, &str); 10] = [
    ("ParameterName", "name"),
    ("ObjectType", "objectType"),
    ("DataType", "dataType"),
    ("ObjFlags", "objFlags"),
    ("AccessType", "accessType"),
    ("LowLimit", "lowLimit"),
    ("HighLimit", "highLimit"),
    ("DefaultValue", "defaultValue"),
    ("ParameterValue", "actualValue"),
    ("Denotation", "denotation"),
];

impl<'a, 'x> Reader<'a, 'x> {
    /// The lists of objects, and a section for each object and sub-index.
    pub(super) fn objects(&self, list: Node<'x, 'x>) -> Vec<Section<'a>> {
        let mut lists = [
            self.section("MandatoryObjects".into(), list),
            self.section("OptionalObjects".into(), list),
            self.section("ManufacturerObjects".into(), list),
        ];
        for list in &mut lists {
            // The comments in an object are for the object alone.
            list.lines = 0..0;
        }
        let mut sections = Vec::new();
        for object in list.children().filter(|node| is(*node, "CANopenObject")) {
            let index = digits(object, "index");
            let number = u16::from_str_radix(&index, 16).ok();
            let [mandatory, optional, manufacturer] = &mut lists;
            let list = match number {
                Some(0x1000 | 0x1001 | 0x1018) => Some(mandatory),
                Some(0x2000..=0x5FFF) => Some(manufacturer),
                Some(0x1000..) => Some(optional),
                _ => None,
            };
            if let Some(list) = list {
                self.list(list, object);
            }
            let name = number.map_or(index, |number| format!("{number:04X}"));
            let mut section = self.section(name.clone(), object);
            let is_sub = |node: &Node<'_, '_>| is(*node, "CANopenSubObject");
            let is_inside = |node: Node<'_, '_>| node.ancestors().any(|above| is_sub(&above));
            section.comments = self.comments(object, is_inside);
            self.put(&mut section, "SubNumber", (object, "subNumber"), as_it_is);
            self.value(&mut section, object);
            sections.push(section);
            let subs = object.children();
            for sub in subs.filter(|node| is(*node, "CANopenSubObject")) {
                let number = digits(sub, "subIndex");
                let mut section = self.section(format!("{name}sub{number}"), sub);
                section.comments = self.comments(sub, |_| false);
                self.value(&mut section, sub);
                sections.push(section);
            }
        }
        for list in &mut lists {
            let count = list.keys.len().to_string();
            list.put("SupportedObjects", count);
        }
        lists.into_iter().chain(sections).collect()
    }

    fn list(&self, list: &mut Section<'a>, object: Node<'_, '_>) {
        let number = (list.keys.len() + 1).to_string();
        let before = list.keys.len();
        self.put(list, "", (object, "index"), hexadecimal);
        if let Some(key) = list.keys.get_mut(before) {
            key.name = number.into();
        }
    }

    /// The keys of a value, its own and those of the parameter it refers to.
    fn value(&self, section: &mut Section<'a>, node: Node<'_, 'x>) {
        for (key, attribute) in ATTRIBUTES {
            let spell = match attribute {
                "dataType" | "objFlags" => hexadecimal,
                _ => as_it_is as fn(&str) -> String,
            };
            self.put(section, key, (node, attribute), spell);
        }
        let parameter = node.attribute("uniqueIDRef");
        if let Some(parameter) = parameter.and_then(|id| self.parameters.get(id)) {
            self.parameter(section, *parameter);
            if section.key("AccessType").is_none() && !has_subs(node) {
                self.default_access(section, *parameter);
            }
            if section.key("DataType").is_none() && !has_subs(node) {
                self.parameter_type(section, *parameter);
            }
        }
        self.mapping(section, node);
        if !self.is_configured {
            let is_value = |key: &Key<'_>| key.name == "ParameterValue" || key.name == "Denotation";
            section.keys.retain(|key| !is_value(key));
        }
    }

    /// What the parameter says and the object does not.
    fn parameter(&self, section: &mut Section<'a>, parameter: Node<'x, 'x>) {
        let range = find(parameter, "range");
        let limit = |name: &str| range.and_then(|range| find(range, name));
        for (key, node, attribute, spell) in [
            (
                "AccessType",
                Some(parameter),
                "access",
                access as fn(&str) -> String,
            ),
            ("LowLimit", limit("minValue"), "value", as_it_is),
            ("HighLimit", limit("maxValue"), "value", as_it_is),
            (
                "DefaultValue",
                child(parameter, "defaultValue"),
                "value",
                as_it_is,
            ),
            (
                "ParameterValue",
                child(parameter, "actualValue"),
                "value",
                as_it_is,
            ),
        ] {
            if let Some(node) = node.filter(|_| section.key(key).is_none()) {
                self.put(section, key, (node, attribute), spell);
            }
        }
        let unit = child(parameter, "unit").and_then(|unit| find(unit, "label"));
        if let Some(unit) = unit.and_then(|label| label.text().map(|text| (label, one_line(text))))
        {
            section.comments.push(Comment {
                text: format!("Unit={}", unit.1).into(),
                span: self.source.span(unit.0.range()),
                position: 0,
            });
        }
    }

    /// The access of a parameter that names none: the schema's default.
    fn default_access(&self, section: &mut Section<'a>, parameter: Node<'_, '_>) {
        let range = parameter.range();
        let tag = range.start..range.start + 1 + parameter.tag_name().name().len();
        let span = self.source.span(tag);
        section.keys.push(Key {
            name: "AccessType".into(),
            value: access("read").into(),
            name_span: span,
            span,
        });
    }

    /// The type that a parameter names by an element, such as `<UINT/>`.
    fn parameter_type(&self, section: &mut Section<'a>, parameter: Node<'x, 'x>) {
        let has_value = section.key("DefaultValue").is_some();
        let found = parameter
            .children()
            .find_map(|node| Some((node, data_type(node.tag_name().name(), has_value)?)));
        if let Some((node, data_type)) = found {
            let span = self.source.span(node.range());
            section.keys.push(Key {
                name: "DataType".into(),
                value: format!("0x{:04X}", data_type.code()).into(),
                name_span: span,
                span,
            });
        }
    }

    /// PDOmapping names directions; in an EDS the access does.
    fn mapping(&self, section: &mut Section<'a>, node: Node<'_, '_>) {
        let mapping = node.attribute("PDOmapping").unwrap_or_default();
        self.put(
            section,
            "PDOMapping",
            (node, "PDOmapping"),
            |value| match value {
                "no" => "0".into(),
                "default" | "optional" | "TPDO" | "RPDO" => "1".into(),
                _ => value.into(),
            },
        );
        let is_access = |key: &&mut Key<'_>| key.name == "AccessType";
        if let Some(key) = section.keys.iter_mut().find(is_access)
            && key.value == "rw"
        {
            match mapping {
                "TPDO" => key.value = "rwr".into(),
                "RPDO" => key.value = "rww".into(),
                _ => {}
            }
        }
    }
}

/// The hexadecimal digits of an attribute; some tools put `0x` in front of them.
fn digits(node: Node<'_, '_>, attribute: &str) -> String {
    let text = one_line(node.attribute(attribute).unwrap_or_default());
    let bare = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    bare.unwrap_or(&text).to_owned()
}

fn child<'x>(node: Node<'x, 'x>, name: &str) -> Option<Node<'x, 'x>> {
    node.children().find(|node| is(*node, name))
}

/// Whether an object is an ARRAY or a RECORD: its sub-indices have types, it has none.
fn has_subs(node: Node<'_, '_>) -> bool {
    matches!(
        node.attribute("objectType").map(str::trim),
        Some("8" | "9" | "08" | "09")
    )
}

/// The types that parameters name by an element (IEC 61131-3). Of two for one type the first is written.
const TYPES: [(&str, DataType); 18] = [
    ("BOOL", DataType::Boolean),
    ("SINT", DataType::Integer8),
    ("CHAR", DataType::Integer8),
    ("INT", DataType::Integer16),
    ("DINT", DataType::Integer32),
    ("LINT", DataType::Integer64),
    ("USINT", DataType::Unsigned8),
    ("BYTE", DataType::Unsigned8),
    ("UINT", DataType::Unsigned16),
    ("WORD", DataType::Unsigned16),
    ("UDINT", DataType::Unsigned32),
    ("DWORD", DataType::Unsigned32),
    ("ULINT", DataType::Unsigned64),
    ("LWORD", DataType::Unsigned64),
    ("REAL", DataType::Real32),
    ("LREAL", DataType::Real64),
    ("STRING", DataType::VisibleString),
    ("WSTRING", DataType::UnicodeString),
];

/// What stands for everything that IEC 61131-3 has no name for.
const BITS: &str = "BITSTRING";

/// The type that a parameter names. A BITSTRING is an OCTET_STRING where it has a value, and a DOMAIN where it has none, as the
/// editor of CANopenNode has it.
fn data_type(name: &str, has_value: bool) -> Option<DataType> {
    if name == BITS {
        return Some(match has_value {
            true => DataType::OctetString,
            false => DataType::Domain,
        });
    }
    let found = TYPES.iter().find(|(own, _)| *own == name);
    found.map(|(_, data_type)| *data_type)
}

/// The element that names a type.
pub(super) fn type_name(data_type: DataType) -> &'static str {
    let found = TYPES.iter().find(|(_, own)| *own == data_type);
    found.map_or(BITS, |(name, _)| *name)
}

/// What parameters can be accessed for, and what data sheets call it.
const ACCESSES: [(&str, Access); 7] = [
    ("const", Access::Constant),
    ("read", Access::ReadOnly),
    ("noAccess", Access::ReadOnly),
    ("write", Access::WriteOnly),
    ("readWrite", Access::ReadWrite),
    ("readWriteInput", Access::ReadWriteInput),
    ("readWriteOutput", Access::ReadWriteOutput),
];

/// The access of a parameter as that of an object.
fn access(value: &str) -> String {
    let found = ACCESSES.iter().find(|(name, _)| *name == value);
    found.map_or(value, |(_, access)| access.name()).into()
}

/// The access of a parameter.
pub(super) fn parameter_access(access: Access) -> &'static str {
    let found = ACCESSES.iter().find(|(_, own)| *own == access);
    found.map_or("", |(name, _)| *name)
}
