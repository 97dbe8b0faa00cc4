//! Comments that say something to people, and to this tool about its own findings.

/// Comments of a section, each without its `;`. All are equal: they say nothing about what is meant.
#[derive(Clone, Debug, Default)]
pub struct Remarks(pub Vec<String>);

impl PartialEq for Remarks {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Remarks {}
