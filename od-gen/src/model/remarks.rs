//! What says nothing about the device: comments, and what the file says to tools.

/// Comments of a section, each without its `;`. All are equal: they say nothing about what is meant.
#[derive(Clone, Debug, Default)]
pub struct Remarks(pub Vec<String>);

impl PartialEq for Remarks {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Remarks {}

/// The sections Tools, Tool1 and their like, and StandardDataTypes: names, each with its keys and values, as they stand in the
/// file. All are equal: they say nothing about the device.
#[derive(Clone, Debug, Default)]
pub struct Tools(pub Vec<(String, Vec<(String, String)>)>);

impl PartialEq for Tools {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Tools {}
