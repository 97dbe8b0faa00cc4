//! Rules: the objects of CiA 301 and CiA 402 are as their standard has them.

use super::{Known, Rights, of};
use crate::diagnostic::Findings;
use crate::model::{Entry, Field, Object, ObjectType};
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &STANDARD_KIND,
    &STANDARD_TYPE,
    &STANDARD_ACCESS,
    &MISSING_SUB_INDEX,
    &UNKNOWN_SUB_INDEX,
];

static STANDARD_KIND: Rule = Rule::masters(
    "standard-kind",
    "An object of CiA 301 or CiA 402 is the VAR, ARRAY or RECORD that the standard has.",
    "A master that knows the standard asks for sub-indices that are not there, or misses some. A RECORD where an ARRAY is due, \
     and the reverse, harms nobody but tools that show one line for all elements.",
);

pub(crate) static STANDARD_TYPE: Rule = Rule::masters(
    "standard-type",
    "An object of CiA 301 or CiA 402 has the data type of the standard.",
    "Masters map and write these objects by the standard, without a look into the data sheet: with another length or sign they \
     fail, or write something else. The firmware's own layers ask for the standard's types too.",
).strict();

pub(crate) static STANDARD_ACCESS: Rule = Rule::masters(
    "standard-access",
    "An object of CiA 301 or CiA 402 can be read and written as the standard says.",
    "What the device reports (statusword, actual values, identity) is read-only, what commands it can be written. Where the \
     standard lets the device choose, any access is right.",
);

static MISSING_SUB_INDEX: Rule = Rule::masters(
    "missing-sub-index",
    "An object of CiA 301 or CiA 402 has the sub-indices that the standard asks for.",
    "A PDO, for instance, is nothing without its COB-ID and its transmission type. When this is silenced, the device answers a \
     request for the missing one with 06090011h.",
).strict();

static UNKNOWN_SUB_INDEX: Rule = Rule::warning(
    "unknown-sub-index",
    "An object of CiA 301 or CiA 402 has no sub-indices beyond those of the standard.",
    "The standard keeps the others for its next version. Objects of the manufacturer are at 2000h to 5FFFh.",
);

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for object in &model.objects {
        let Some((standard, known)) = of(model, object.index) else {
            continue;
        };
        if check_kind(object, standard, known, findings) {
            check_subs(model, object, standard, known, findings);
        }
    }
}

/// Whether its sub-indices can be compared with those of the standard.
fn check_kind(object: &Object, standard: &str, known: &Known, findings: &mut Findings) -> bool {
    let (is, should) = (object.object_type, known.kind);
    if is != should && is != ObjectType::Null {
        let index = object.index;
        let message = format!(
            "{index:04X}h is {}, but {standard} makes it {}",
            a(is.name()),
            a(should.name())
        );
        let span = object.places.of(Field::ObjectType);
        let finding = findings.report(&STANDARD_KIND, span, message);
        finding.help(format!("write `ObjectType=0x{:X}`", should.code()));
    }
    is.has_subs() == should.has_subs()
}

fn a(kind: &str) -> String {
    let article = if kind.starts_with('A') { "an" } else { "a" };
    format!("{article} {kind}")
}

fn check_subs(
    model: &Subject<'_>,
    object: &Object,
    standard: &str,
    known: &Known,
    findings: &mut Findings,
) {
    let index = object.index;
    for entry in &object.entries {
        // Sub-index 0 of an object with sub-indices is the same everywhere.
        if object.object_type.has_subs() && entry.sub == 0 {
            continue;
        }
        let Some(sub) = known.sub(entry.sub) else {
            let message = format!("{standard} has no {index:04X}h:{:X}", entry.sub);
            findings.report(&UNKNOWN_SUB_INDEX, entry.places.section, message);
            continue;
        };
        if let Some(should) = sub.data_type.filter(|should| *should != entry.data_type) {
            let is = entry.data_type.name();
            let place = place(object, entry);
            let message = format!("{place} is {is}, but {standard} makes it {}", should.name());
            let span = entry.places.of(Field::DataType);
            let finding = findings.report(&STANDARD_TYPE, span, message);
            finding.help(format!("write `DataType=0x{:04X}`", should.code()));
        }
        check_access(object, entry, sub.access, standard, findings);
    }
    for sub in known.subs.iter().filter(|sub| sub.is_needed) {
        let first = *sub.subs.start();
        if first != 0 && model.lacks(index, first) {
            let message =
                format!("{index:04X}h has no sub-index {first}, which {standard} asks for");
            findings.report(&MISSING_SUB_INDEX, object.places.section, message);
        }
    }
}

fn check_access(
    object: &Object,
    entry: &Entry,
    rights: Rights,
    standard: &str,
    findings: &mut Findings,
) {
    // What could not be read has been reported.
    let is_read = entry.places.has(Field::AccessType);
    if rights.allow(entry.access) || !is_read {
        return;
    }
    let (place, is) = (place(object, entry), entry.access.name());
    let message = format!("{place} is {is}, but {standard} makes it {}", rights.name());
    let span = entry.places.of(Field::AccessType);
    findings.report(&STANDARD_ACCESS, span, message);
}

/// Index and sub-index, the latter only where there are several.
fn place(object: &Object, entry: &Entry) -> String {
    if object.object_type.has_subs() {
        format!("{:04X}h:{:X}", object.index, entry.sub)
    } else {
        format!("{:04X}h", object.index)
    }
}
