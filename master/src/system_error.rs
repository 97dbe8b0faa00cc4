//! Errors of the operating system as part of a sentence.

use std::fmt::Display;

/// The text without Rust's "(os error 98)" and in small letters; a text of our own as it is.
pub fn plain(error: impl Display) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((plain, _)) => plain.to_lowercase(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[test]
    fn only_what_the_system_says_is_changed() {
        let missing = io::Error::from_raw_os_error(2);
        assert!(missing.to_string().ends_with("(os error 2)"));
        assert_eq!(plain(missing), "no such file or directory");
        assert_eq!(plain(io::Error::other("Another drive")), "Another drive");
    }
}
