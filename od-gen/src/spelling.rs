//! What somebody may have meant who misspelled a name.

/// The known name that is nearest to one that is not known, capital and small letters being equal; `None` where all are far.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_ascii_lowercase();
    let distance = |known: &str| strsim::osa_distance(&name, &known.to_ascii_lowercase());
    let near = known.into_iter().map(|known| (distance(known), known));
    let near = near.filter(|(distance, _)| *distance <= 1 + name.len() / 6);
    near.min().map(|(_, known)| known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_near_that_differ_in_a_letter_or_two() {
        let known = ["DefaultValue", "DataType", "LowLimit", "HighLimit"];
        for (name, near) in [
            ("DefautValue", Some("DefaultValue")),
            ("datatpye", Some("DataType")),
            ("LowLimits", Some("LowLimit")),
            ("Limit", None),
            ("Unit", None),
            ("", None),
        ] {
            assert_eq!(nearest(name, known), near, "{name}");
        }
    }
}
