use super::*;
use crate::report::parse;

fn small() -> Model {
    parse(
        "folder/small.eds",
        include_str!("../../tests/data/small.eds"),
    )
    .unwrap()
}

#[test]
fn markdown_of_the_small_device() {
    insta::assert_snapshot!(markdown(&small()));
}

#[test]
fn the_page_needs_no_other_file() {
    let page = html(&small());
    for outside in ["src=", "http://", "https://", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn every_link_of_the_page_leads_somewhere() {
    let page = html(&small());
    let (page, _) = page.split_once("<script>").unwrap();
    for link in page.split("href=\"#").skip(1) {
        let target = link.split('"').next().unwrap();
        assert!(page.contains(&format!("id=\"{target}\"")), "{target}");
    }
}

#[test]
fn names_cannot_break_out_of_the_page_or_a_table() {
    let mut model = small();
    model.objects[0].name = "<script>alert(1)</script> a|b".into();
    assert!(!html(&model).contains("<script>alert"));
    assert!(markdown(&model).contains(r"\<script\>alert(1)\</script\> a\|b"));
}

#[test]
fn markdown_of_every_type_in_a_configured_device() {
    let text = include_str!("../../tests/data/every.dcf");
    let model = crate::report::Report::new("every.dcf", text).model;
    insta::assert_snapshot!(markdown(&model));
}

#[test]
fn what_is_for_tools_is_not_in_the_reference() {
    let sheet = include_str!("../../tests/data/small.eds").replace(
        "ParameterName=Pattern\n",
        "; Turns it around.\n;Unit=rpm\n;od-gen: allow const-mappable because nothing\nParameterName=Pattern\n",
    );
    let page = html(&crate::report::Report::new("x.eds", &sheet).model);
    assert!(page.contains("<p>Turns it around.</p>"));
    assert!(page.contains("<td>rpm</td>"));
    assert!(!page.contains("because"));
}
