//! The text of a data sheet: lines that are nothing, control characters, line ends, letters.

use super::*;

#[test]
fn lines_that_are_nothing_are_found() {
    finds(
        "FileVersion=1",
        "nonsense",
        "FileVersion=1",
        "`nonsense` is neither a section nor key=value nor a ;comment",
    );
    finds(
        "[FileInfo]",
        "Early=1\n[FileInfo]",
        "[FileInfo]",
        "`Early` stands before the first section",
    );
    finds(
        "[1000]",
        "[1000] ; the type",
        "[1000]",
        "the section is read as `[1000]`, up to the `;`",
    );
    finds(
        "[1000]",
        "[1000] x",
        "[1000]",
        "`[1000] x` is not a section: it must end with its `]`",
    );
    finds(
        "[1000]",
        "[1000",
        "[1000]",
        "`[1000` is not a section: it must end with its `]`",
    );
    finds(
        "EDSVersion=4.0",
        "EDSVersion=4.0 ; old",
        "EDSVersion",
        "the value of `EDSVersion` is read as `4.0`, up to the `;`",
    );
}

#[test]
fn control_characters_are_found_and_do_no_other_harm() {
    let old = "ParameterName=Flag";
    for (control, code) in [
        ('\0', "0000"),
        ('\u{1B}', "001B"),
        ('\u{7F}', "007F"),
        ('\u{85}', "0085"),
        ('\u{202E}', "202E"),
    ] {
        for new in [
            format!("ParameterName=Fl{control}ag"),
            format!("Param{control}eterName=Flag"),
            format!(";a comment{control}!\nParameterName=Flag"),
        ] {
            let message = format!("control character U+{code} is left out");
            finds(old, &new, old, &message);
        }
    }
    assert_eq!(findings(old, "ParameterName\t=\tFlag\t"), "");
}

#[test]
fn o04_a_carriage_return_alone_ends_a_line_too() {
    let same = small();
    for end in ["\r", "\r\r\n"] {
        let text = SMALL.replace('\n', end);
        let report = Report::new("small.eds", &text);
        assert_eq!(said(&report), "");
        assert_eq!(report.model, same);
    }
}

#[test]
fn letters_of_windows_1252_are_read() {
    let name = b"DefaultValue=\x80 \x84a\x93 \x99 \x9F \xE9\nParameterName=Flag";
    let (before, behind) = SMALL.split_once("ParameterName=Flag").unwrap();
    let bytes = [before.as_bytes(), b";", name, behind.as_bytes()].concat();
    let report = Report::of_bytes("small.eds", &bytes);
    let line = line_of("ParameterName=Flag");
    assert_eq!(
        said(&report),
        format!("{line}: this is not UTF-8: the file is read as Windows-1252")
    );
    let shown = report.source.line(u32::try_from(line).unwrap());
    assert_eq!(
        shown,
        Some(";DefaultValue=\u{20AC} \u{201E}a\u{201C} \u{2122} \u{178} \u{E9}")
    );
    // Five bytes of the code page are no letters.
    let bytes = [
        before.as_bytes(),
        b";\x81\xFF\nParameterName=Flag",
        behind.as_bytes(),
    ]
    .concat();
    let said = said(&Report::of_bytes("small.eds", &bytes));
    assert!(
        said.contains("control character U+0081 is left out"),
        "{said}"
    );
}
