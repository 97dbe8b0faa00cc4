//! Sub-indices whose object has no section.

use super::sections::Sections;
use super::{Broken, objects};
use crate::diagnostic::Findings;
use crate::document::Section;
use crate::model::{Model, Object, ObjectType, Places};
use crate::rules::structure as rule;

/// Reads them; a RECORD without a name keeps what they say.
pub(super) fn read(
    sections: &Sections<'_>,
    model: &mut Model,
    broken: &mut Broken,
    findings: &mut Findings,
) {
    for ((index, _), section) in &sections.subs {
        if sections.objects.contains_key(index) {
            continue;
        }
        let name = &section.name;
        let message = format!("[{name}] has no object: there is no section [{index:04X}]");
        findings.report(&rule::SUB_WITHOUT_OBJECT, section.span, message);
        // Where that is silenced there is no such sub-index.
        let is_silenced = findings.allowed(&rule::SUB_WITHOUT_OBJECT, section.span, ());
        let is_nothing = *index < 0x1000 || section.keys.is_empty() || is_silenced.is_some();
        if is_nothing || !broken.objects.insert(*index) {
            continue;
        }
        let mut object = Object {
            index: *index,
            object_type: ObjectType::Record,
            name: format!("Object {index:04X}h"),
            places: Places::new(section.span),
            ..Object::default()
        };
        let nothing = Section::new(format!("{index:04X}"));
        objects::read_subs(&mut object, &nothing, sections, broken, findings);
        let Some(last) = object.entries.last().map(|entry| entry.sub) else {
            continue;
        };
        // It has been said that the object is not there.
        if object.entry(0).is_none() {
            objects::add_sub_0(&mut object, last, section.span);
        }
        model.objects.push(object);
    }
    model.objects.sort_by_key(|object| object.index);
}
