//! What a module adds to the dictionary of its bus coupler is held to the rules about models too, as if the module was plugged.
//!
//! Modules that do not get in each other's way are looked at together. A finding counts when it is about an object of a module: the
//! coupler alone has been looked at before.

use std::collections::BTreeSet;

use super::{CHECKS, Subject};
use crate::diagnostic::Findings;
use crate::model::{Field, Model, Module, Object};

pub(super) fn check(subject: &Subject<'_>, findings: &mut Findings) {
    let mut waiting: Vec<&Module> = subject.modules.iter().collect();
    waiting.retain(|module| !module.fixed.is_empty());
    while !waiting.is_empty() {
        let mut model = subject.model.clone();
        let mut lines = BTreeSet::new();
        waiting.retain(|module| {
            let is_taken = |object: &Object| model.object(object.index).is_some();
            // What is in the way of its own coupler never gets in; then it is left out, so that the others have their turn.
            let is_in_the_way = module.fixed.iter().any(is_taken);
            if is_in_the_way && !lines.is_empty() {
                return true;
            }
            plug(&mut model, module, &mut lines);
            false
        });
        let plugged = Subject {
            model: &model,
            broken: subject.broken,
        };
        let mut found = findings.same_file();
        for check in CHECKS {
            check(&plugged, &mut found);
        }
        findings.merge(found, |finding| lines.contains(&finding.span.line));
    }
}

/// Adds the objects of a module, and the lines that they stand on.
fn plug(model: &mut Model, module: &Module, lines: &mut BTreeSet<u32>) {
    for object in &module.fixed {
        let entries = object.entries.iter().map(|entry| &entry.places);
        for places in entries.chain([&object.places]) {
            lines.insert(places.section.line);
            lines.extend(Field::ALL.iter().map(|field| places.of(*field).line));
        }
        let at = model
            .objects
            .binary_search_by_key(&object.index, |other| other.index);
        if let Err(at) = at {
            model.objects.insert(at, object.clone());
        }
    }
}
