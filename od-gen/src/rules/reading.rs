//! Rules of the text: its encoding, its lines, its keys (CiA 306, 4.3), and the comments that silence findings.

use super::Rule;

pub(crate) const RULES: &[&Rule] = &[
    &NOT_TEXT,
    &NOT_XML,
    &NOT_UTF_8,
    &CONTROL_CHARACTER,
    &STRAY_LINE,
    &UNCLOSED_SECTION,
    &KEY_OUTSIDE,
    &TRAILING_COMMENT,
    &REPEATED_SECTION,
    &REPEATED_KEY,
    &CONTRADICTING_KEY,
    &UNKNOWN_SECTION,
    &UNKNOWN_KEY,
    &KEY_OF_DCF,
    &ALLOWANCE_WITHOUT_REASON,
    &ALLOWANCE_OF_NO_RULE,
    &ALLOWANCE_REFUSED,
    &UNUSED_ALLOWANCE,
];

pub(crate) static NOT_TEXT: Rule = Rule::fatal(
    "not-text",
    "The file is a text.",
    "More than an eighth of its bytes are zero: it is a program, an archive or a damaged file. It cannot be silenced, as there is no \
     comment to be read.",
);

pub(crate) static NOT_XML: Rule = Rule::fatal(
    "not-xml",
    "A file that begins with `<` is a data sheet in XML (CiA 311).",
    "It is well-formed XML and has a CANopenObjectList. A document type definition may be there, with entities that stand for plain \
     text; what lies outside of the file is not read. It cannot be silenced, as nothing of the file can be read then, its comments \
     neither.",
);

pub(crate) static NOT_UTF_8: Rule = Rule::masters(
    "not-utf-8",
    "The file is in UTF-8.",
    "A file that begins as UTF-16 does is read as that. Other bytes that are not UTF-8 are taken for Windows-1252 (Latin-1 \
     with quotes and a euro sign), as older tools write it; letters of other code pages come out wrong. Save the file in \
     UTF-8.",
);

pub(crate) static CONTROL_CHARACTER: Rule = Rule::masters(
    "control-character",
    "There are no control characters in the file.",
    "Nobody sees NUL or a mark of direction in an editor. They are left out while reading, and a file that has them \
     is not formatted, but for NUL and the end mark 1Ah.",
);

pub(crate) static STRAY_LINE: Rule = Rule::error(
    "stray-line",
    "Each line is a section, key=value or a comment.",
    "A line that is nothing of these has no meaning; often it is the rest of a text that an editor has wrapped. When \
     this is silenced, the line is skipped.",
);

pub(crate) static UNCLOSED_SECTION: Rule = Rule::error(
    "unclosed-section",
    "The name of a section ends with `]`, and nothing follows it.",
    "What follows `]` is skipped when this is silenced.",
);

pub(crate) static KEY_OUTSIDE: Rule = Rule::error(
    "key-before-section",
    "Each key stands in a section.",
    "A key above the first section belongs to nothing. It is skipped when this is silenced.",
);

pub(crate) static TRAILING_COMMENT: Rule = Rule::masters(
    "trailing-comment",
    "A comment takes a line of its own.",
    "CiA 306 knows no comments behind a value. Some readers cut them off, as this one does, others take them for a \
     part of the value.",
);

pub(crate) static REPEATED_SECTION: Rule = Rule::error(
    "repeated-section",
    "Each section is there once, however its name is spelled.",
    "[2000sub1] and [2000sub01] are the same section. Readers differ in which of two sections counts. Here the first one does when this is silenced.",
);

pub(crate) static REPEATED_KEY: Rule = Rule::masters(
    "repeated-key",
    "Each key is there once in its section.",
    "The key is there twice with the same value. Remove one of them.",
);

pub(crate) static CONTRADICTING_KEY: Rule = Rule::error(
    "contradicting-key",
    "A key does not have two values.",
    "Readers differ in which of two keys counts. Here the first one does when this is silenced.",
);

pub(crate) static UNKNOWN_SECTION: Rule = Rule::masters(
    "unknown-section",
    "Each section is one of CiA 306.",
    "Vendors keep data of their tools in sections of their own. They are kept when the file is printed again, and \
     mean nothing here. A mistake in the spelling of a section shows up here too.",
);

pub(crate) static UNKNOWN_KEY: Rule = Rule::masters(
    "unknown-key",
    "Each key is one of CiA 306.",
    "Vendors keep data of their tools in keys of their own. They are kept when the file is printed again, and mean \
     nothing here. A mistake in the spelling of a key shows up here too.",
);

pub(crate) static KEY_OF_DCF: Rule = Rule::warning(
    "key-of-a-dcf",
    "Keys of a configured device stand in a DCF.",
    "ParameterValue, UploadFile, DownloadFile, Denotation and the section DeviceComissioning describe one configured \
     device. In a data sheet, which describes all devices of a kind, they mean nothing.",
);

pub(crate) static ALLOWANCE_WITHOUT_REASON: Rule = Rule::warning(
    "allowance-without-reason",
    "A finding is silenced with a reason.",
    "Write `;od-gen: allow RULE because REASON` into the section that the finding is in, or above the first section \
     for the whole file. Several rules are separated by commas. What concerns bindings or the values of a configuration is silenced \
     above the first section, or in those files.",
);

pub(crate) static ALLOWANCE_OF_NO_RULE: Rule = Rule::warning(
    "allowance-of-no-rule",
    "An allowance names a rule that exists.",
    "`od-gen rules` lists the rules.",
);

pub(crate) static ALLOWANCE_REFUSED: Rule = Rule::warning(
    "allowance-refused",
    "An allowance names a rule that can be silenced.",
    "What is no text or no XML cannot be read at all, and so not silenced.",
);

pub(crate) static UNUSED_ALLOWANCE: Rule = Rule::warning(
    "unused-allowance",
    "An allowance silences something.",
    "What it was for is gone. Remove it, so that it does not hide the next mistake.",
);
