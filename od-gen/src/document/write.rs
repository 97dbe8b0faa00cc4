//! From a [`Document`] to text.

use super::{Comment, Document, Section};

/// Writes the sections in their order: each after a blank line, the comments where they belong.
pub(crate) fn write(document: &Document<'_>) -> String {
    let mut out = String::new();
    for line in &document.head {
        comment(&mut out, line);
    }
    for section in &document.sections {
        if !out.is_empty() {
            out.push('\n');
        }
        write_section(&mut out, section);
    }
    out
}

fn write_section(out: &mut String, section: &Section<'_>) {
    for line in &section.lead {
        comment(out, line);
    }
    out.push('[');
    out.push_str(&section.name);
    out.push_str("]\n");
    let mut comments = section.comments.iter().peekable();
    for (position, key) in section.keys.iter().enumerate() {
        while let Some(line) = comments.next_if(|comment| comment.position <= position) {
            comment(out, line);
        }
        out.push_str(&key.name);
        out.push('=');
        out.push_str(&key.value);
        out.push('\n');
    }
    for line in comments {
        comment(out, line);
    }
}

fn comment(out: &mut String, comment: &Comment<'_>) {
    out.push(';');
    out.push_str(comment.text.trim_end());
    out.push('\n');
}
