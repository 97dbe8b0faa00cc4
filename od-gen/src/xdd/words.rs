//! Findings in the words of XML: what is asked of an XDD is what is asked of an EDS, and said of its elements and attributes.

use super::device::{FEATURES, IDENTITY};
use super::object::ATTRIBUTES;
use crate::diagnostic::Diagnostic;
use crate::source::Source;

/// Further words of an EDS, and those of XML.
const WORDS: [(&str, &str); 18] = [
    ("PDOMapping", "PDOmapping"),
    ("SubNumber", "subNumber"),
    ("SimpleBootUpMaster", "bootUpMaster"),
    ("NodeID", "nodeID"),
    ("NodeName", "nodeName"),
    ("Baudrate", "actualBaudRate"),
    ("NetNumber", "networkNumber"),
    ("NetworkName", "networkName"),
    ("DeviceInfo", "DeviceIdentity"),
    ("FileInfo", "ProfileBody"),
    ("DeviceComissioning", "deviceCommissioning"),
    ("DummyUsage", "dummyUsage"),
    ("FileVersion", "fileVersion"),
    ("FileName", "fileName"),
    ("CreatedBy", "fileCreator"),
    ("CreationDate", "fileCreationDate"),
    ("ModificationDate", "fileModificationDate"),
    ("EDS", "XDD"),
];

/// Puts a finding about an XDD into its words; what the message does not name is put in front of it.
pub(crate) fn translate(finding: &mut Diagnostic, source: &Source) {
    finding.message = in_words_of_xml(&finding.message);
    finding.help = finding.help.as_deref().map(in_words_of_xml);
    if let Some((_, what)) = &mut finding.other {
        *what = in_words_of_xml(what);
    }
    if let Some(place) = attribute(source, finding)
        && !finding.message.contains(&place)
    {
        finding.message = format!("{place}: {}", finding.message);
    }
}

/// The attribute that a finding points at; the element where that says more.
fn attribute(source: &Source, finding: &Diagnostic) -> Option<String> {
    let line = source.line(finding.span.line)?;
    let column = usize::try_from(finding.span.column).ok()?.checked_sub(1)?;
    let at = line.char_indices().nth(column)?.0;
    let before = line.get(..at)?.strip_suffix(['"', '\''])?;
    let before = before.trim_end().strip_suffix('=')?.trim_end();
    let name = before.split_whitespace().last()?;
    if name != "value" {
        return Some(name.into());
    }
    let (_, element) = before.rsplit_once('<')?;
    element.split_whitespace().next().map(str::to_owned)
}

/// A text about an EDS as one about an XDD.
pub(crate) fn in_words_of_xml(text: &str) -> String {
    let allowance = "`;od-gen: allow RULE because REASON`";
    let text = text.replace(allowance, "`<!-- od-gen: allow RULE because REASON -->`");
    let mut said = String::with_capacity(text.len());
    let mut rest = text.as_str();
    while let Some(first) = rest.chars().next() {
        if let Some((section, behind)) = section(rest) {
            // `the section [2000]` is an element.
            let bare = said.strip_suffix("the section ").map(str::len);
            said.truncate(bare.unwrap_or(said.len()));
            said.push_str(&section);
            rest = behind;
            continue;
        }
        let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
        let end = rest.find(|letter| !is_word(letter)).unwrap_or(rest.len());
        if end == 0 {
            said.push(first);
            rest = rest.get(first.len_utf8()..).unwrap_or_default();
            continue;
        }
        let (own, behind) = rest.split_at(end);
        rest = behind;
        let Some(name) = word(own) else {
            said.push_str(own);
            continue;
        };
        said.push_str(name);
        // `DefaultValue=5` is an attribute with its value.
        let Some(value) = behind.strip_prefix('=') else {
            continue;
        };
        let is_end = |letter: char| letter.is_whitespace() || "`,;:)".contains(letter);
        let end = value.find(is_end).unwrap_or(value.len());
        let (value, behind) = value.split_at(end);
        let is_flag = FEATURES
            .iter()
            .any(|(_, own, is_flag)| *own == name && *is_flag);
        let value = match (name, value) {
            ("PDOmapping", "0") => "no",
            ("PDOmapping", "1") => "optional",
            (_, "0") if is_flag || name == "bootUpMaster" => "false",
            (_, "1") if is_flag || name == "bootUpMaster" => "true",
            _ => value,
        };
        said.push_str(&format!("=\"{value}\""));
        rest = behind;
    }
    said
}

/// What XML calls a key or a section.
fn word(own: &str) -> Option<&'static str> {
    let identity = IDENTITY.iter().map(|(element, key)| (*key, *element));
    let features = FEATURES
        .iter()
        .map(|(key, attribute, _)| (*key, *attribute));
    let all = ATTRIBUTES.into_iter().chain(identity).chain(features);
    let mut all = all.chain(WORDS);
    all.find(|(eds, _)| *eds == own).map(|(_, xml)| xml)
}

/// `[2000]` and `[2000sub1]` as elements, and what follows.
fn section(text: &str) -> Option<(String, &str)> {
    let (name, behind) = text.strip_prefix('[')?.split_once(']')?;
    let (index, sub) = name.split_once("sub").unwrap_or((name, ""));
    let is_right = |digits: &str| digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    if index.len() != 4 || !is_right(index) || !is_right(sub) {
        return None;
    }
    let element = match sub {
        "" => format!("CANopenObject {index}"),
        _ => format!("CANopenSubObject {sub:0>2} of CANopenObject {index}"),
    };
    Some((element, behind))
}

#[cfg(test)]
mod tests {
    use super::in_words_of_xml;

    #[test]
    fn keys_are_attributes_and_sections_are_elements() {
        for (eds, xml) in [
            ("HighLimit -9 does not fit", "highLimit -9 does not fit"),
            (
                "the section [2000] is already on line 5",
                "CANopenObject 2000 is already on line 5",
            ),
            (
                "[2000sub1] has no DataType",
                "CANopenSubObject 01 of CANopenObject 2000 has no dataType",
            ),
            ("write `DefaultValue=0x10`", "write `defaultValue=\"0x10\"`"),
            (
                "PDOMapping=1, LSS_Supported=0",
                "PDOmapping=\"optional\", layerSettingServiceSlave=\"false\"",
            ),
            ("MyDataTypes [abc] stay", "MyDataTypes [abc] stay"),
            (
                "write `;od-gen: allow RULE because REASON`",
                "write `<!-- od-gen: allow RULE because REASON -->`",
            ),
        ] {
            assert_eq!(in_words_of_xml(eds), xml);
        }
    }
}
