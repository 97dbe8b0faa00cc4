//! The reader of data sheets: any bytes, in any of its notations.
//!
//! Whatever they are, there is a report whose findings point into the file and can be shown. A file without errors is printed
//! and read as the same again, and formatting it twice changes nothing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use od_gen::{Colour, Report, format, generate, print};

fuzz_target!(|bytes: &[u8]| {
    let report = Report::of_bytes("fuzzed.eds", bytes);
    let lines = report.source.line_count();
    for finding in &report.findings {
        assert!((1..=lines).contains(&finding.span.line), "{finding}");
    }
    assert!(report.findings.is_sorted_by_key(|finding| finding.span));
    let _ = report.render(Colour::Never);

    let text = report.source.text();
    if !text.trim_start().starts_with('<')
        && let Ok(formatted) = format("fuzzed.eds", text)
    {
        let again = Report::new("fuzzed.eds", &formatted);
        assert_eq!(again.model, report.model, "{formatted}");
        assert_eq!(format("fuzzed.eds", &formatted).as_ref(), Ok(&formatted));
    }
    if !report.has_errors() && report.silenced.is_empty() {
        let printed = print(&report.model);
        let mut again = Report::new("fuzzed.eds", &printed).model;
        again.kind = report.model.kind;
        assert_eq!(again, report.model, "{printed}");
        let _ = generate(&report.model, od_gen::Options::DEVICE);
    }
});
