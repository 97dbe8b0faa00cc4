//! Families of devices.

use std::fs;
use std::path::PathBuf;

use crate::model::DefaultValue;
use crate::report::Report;
use crate::{Colour, diff};

const SMALL: &str = include_str!("../../tests/data/small.eds");

/// Another object, a default of one that is there, and one more sub-index.
const PART: &str = "\
; what the pump has
[3000]
ParameterName=Flow
DataType=0x0006
AccessType=rw
DefaultValue=70

[2001]
;Unit=mm
DefaultValue=-4

[200Asub3]
ParameterName=Element
DataType=0x0004
AccessType=rw

[200Asub0]
DefaultValue=3
";

const RECIPE: &str = "\
[base]
eds = \"base.eds\"
remove = [\"2004h-2005h\"]

[[part]]
eds = \"parts/pump.eds\"

[identity]
vendor_id = 0x22
product_name = \"Pump\"

[defaults]
\"1400h:2\" = 254
";

/// A folder with these files; the recipe among them is `device.toml`.
struct Family(tempfile::TempDir);

impl Family {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("parts")).unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn report(&self) -> Report {
        Report::read(&self.path("device.toml")).unwrap()
    }

    /// The findings, with names of files from this folder.
    fn said(&self, report: &Report) -> String {
        let lines = report.findings.iter().map(ToString::to_string);
        let folder = format!("{}/", self.0.path().display());
        lines.collect::<Vec<_>>().join("\n").replace(&folder, "")
    }
}

fn family(recipe: &str, part: &str) -> Family {
    Family::new(&[
        ("base.eds", SMALL),
        ("parts/pump.eds", part),
        ("device.toml", recipe),
    ])
}

#[test]
fn a_device_is_its_base_with_its_parts() {
    let family = family(RECIPE, PART);
    let report = family.report();
    assert!(!report.has_errors(), "{}", family.said(&report));
    let base = Report::new("base.eds", SMALL);
    let differences = diff::diff(&base.model, &report.model);
    let differences: Vec<String> = differences.iter().map(ToString::to_string).collect();
    insta::assert_snapshot!(differences.join("\n"));
    let flow = report.model.entry(0x3000, 0).unwrap();
    assert_eq!(flow.default, Some(DefaultValue::number(70)));
    // What the part does not state stays as the base has it.
    let twice = report.model.entry(0x2001, 0).unwrap();
    assert!(twice.pdo_mapping && twice.low_limit.is_some());
    assert_eq!(twice.unit(), Some("mm"));
    // What is printed is a data sheet of its own.
    let printed = Report::new("printed.eds", &crate::print(&report.model));
    assert_eq!(diff::diff(&report.model, &printed.model), []);
    assert_eq!(report.variables, [""; 0]);
}

#[test]
fn a_base_alone_is_what_it_is() {
    let recipe = "[base]\neds = \"base.eds\"\n";
    for (name, text) in [
        ("small.eds", SMALL),
        ("types.eds", include_str!("../../tests/data/types.eds")),
        ("broken.eds", include_str!("../../tests/data/broken.eds")),
        ("allowed.eds", include_str!("../../tests/data/allowed.eds")),
        ("coupler.eds", include_str!("../../tests/data/coupler.eds")),
        ("sensor.xdd", include_str!("../../tests/data/sensor.xdd")),
        ("axis402.eds", include_str!("../../../eds/axis402.eds")),
    ] {
        let family = Family::new(&[("base.eds", text), ("device.toml", recipe)]);
        let report = family.report();
        let alone = Report::new("base.eds", text);
        assert_eq!(
            diff::diff(&alone.model, &report.model),
            [],
            "{name}: {}",
            family.said(&report)
        );
        let said = |report: &Report| {
            let findings = report.findings.iter();
            // Lists are written anew, and what the file lacks as a whole is said of the recipe.
            let findings = findings.filter(|finding| {
                let rule = finding.rule.name;
                !rule.starts_with("list-") && finding.span.line > 1
            });
            findings
                .map(|finding| (finding.span, finding.message.clone()))
                .collect::<Vec<_>>()
        };
        assert_eq!(said(&report), said(&alone), "{name}");
    }
}

#[test]
fn findings_name_the_file_and_the_line_of_their_part() {
    let part = PART.replace("DefaultValue=70", "DefaultValue=70000");
    let recipe = RECIPE.replace("254", "300").replace("0x22", "-1");
    let family = family(&recipe, &part);
    let report = family.report();
    assert_eq!(
        family.said(&report).lines().collect::<Vec<_>>(),
        [
            "device.toml:9:13: error[out-of-range]: VendorNumber: -1 is not between 0 and 4294967295",
            "device.toml:9:13: error[default-type]: DefaultValue -1 does not fit UNSIGNED32 (0 to 4294967295)",
            "device.toml:13:13: error[default-type]: DefaultValue 300 does not fit UNSIGNED8 (0 to 255)",
            "parts/pump.eds:6:14: error[default-type]: DefaultValue 70000 does not fit UNSIGNED16 (0 to 65535)",
        ]
    );
    assert_eq!(crate::fix(&report, &recipe), None);
    let shown = report.render(Colour::Never);
    assert!(shown.contains("6 | DefaultValue=70000"), "{shown}");
    assert!(shown.contains("13 | \"1400h:2\" = 300"), "{shown}");
}

#[test]
fn a_part_in_xml_is_told_in_its_words() {
    let xdd = include_str!("../../tests/data/sensor.xdd");
    let spoiled = xdd.replace("highLimit=\"-1\"/>", "highLimit=\"-x\"/>");
    assert_ne!(spoiled, xdd);
    let recipe = "[base]\neds = \"base.eds\"\n[[part]]\neds = \"parts/pump.eds\"\nobjects = [\"2001h\"]\nremove = [\"2001h\"]\n";
    let family = family(recipe, &spoiled);
    let report = family.report();
    let said = family.said(&report);
    assert!(
        said.contains("parts/pump.eds:43:131: error[not-a-number]: highLimit: `-x` is not"),
        "{said}"
    );
    let right = self::family(recipe, xdd).report();
    let object = right.model.object(0x2001).unwrap();
    assert_eq!(object.name, "Samples");
    assert!(
        right
            .model
            .object(0x2000)
            .is_some_and(|object| object.name == "Type")
    );
}

#[test]
fn a_recipe_can_be_made_of_recipes() {
    let outer = "[base]\neds = \"pump.toml\"\n[identity]\nproduct_code = 9\n";
    let family = Family::new(&[
        ("base.eds", SMALL),
        ("parts/pump.eds", PART),
        ("pump.toml", RECIPE),
        ("device.toml", outer),
    ]);
    let report = family.report();
    assert!(!report.has_errors(), "{}", family.said(&report));
    assert_eq!(report.model.device.product_number, Some(9));
    assert_eq!(report.model.device.product_name, "Pump");
    assert_eq!(report.source.parts().len(), 3);
    let around = Family::new(&[("device.toml", "[base]\neds = \"device.toml\"\n")]);
    let report = around.report();
    assert_eq!(
        around.said(&report),
        "device.toml:2:7: error[recipe-part]: `device.toml` is made of itself"
    );
    let long = Family::new(&[("device.toml", "[base]\neds = \"parts/../device.toml\"\n")]);
    assert!(long.said(&long.report()).contains("is made of itself"));
}

#[test]
fn recipes_that_blow_up_end_at_a_limit() {
    let mut files = vec![("base.eds".to_owned(), SMALL.to_owned())];
    for level in 0..7 {
        let next = match level {
            6 => "base.eds".into(),
            _ => format!("level{}.toml", level + 1),
        };
        let part = format!("[[part]]\neds = \"{next}\"\n").repeat(5);
        files.push((
            format!("level{level}.toml"),
            format!("[base]\neds = \"{next}\"\n{part}"),
        ));
    }
    let text = "[base]\neds = \"level0.toml\"\n";
    files.push(("device.toml".to_owned(), text.to_owned()));
    let files: Vec<(&str, &str)> = files
        .iter()
        .map(|(name, text)| (&**name, &**text))
        .collect();
    let family = Family::new(&files);
    let said = family.said(&family.report());
    assert!(
        said.contains("the recipe is made of more than 256 files"),
        "{said}"
    );
}

#[test]
fn every_mistake_of_a_recipe_is_told_with_its_line() {
    let mut said = String::new();
    for (old, new) in [
        ("[identity]", "[identify]"),
        ("base.eds", "no-such.eds"),
        ("parts/pump.eds", "no-such.eds"),
        ("eds = \"base.eds\"\n", ""),
        ("2004h-2005h", "2005h-2004h"),
        ("2004h-2005h", "9000h"),
        ("2004h-2005h", "200Ah:7"),
        ("2004h-2005h", "speed"),
        (
            "\"parts/pump.eds\"",
            "\"parts/pump.eds\"\nobjects = [\"3000h\", \"4000h\"]",
        ),
        ("1400h:2", "1400h:7"),
        ("= 254", "= [254]"),
        ("vendor_id", "maker"),
        ("vendor_id = 0x22", "serial_number = 5"),
        ("0x22", "\"$OD_GEN_TEST_UNSET\""),
    ] {
        assert!(RECIPE.contains(old), "{old}");
        let family = family(&RECIPE.replacen(old, new, 1), PART);
        let found = family.said(&family.report());
        assert!(!found.is_empty(), "{new}");
        said += &format!("{new:?}\n{found}\n\n");
    }
    for rule in crate::rules::recipe::RULES {
        assert!(said.contains(rule.name), "{}", rule.name);
    }
    insta::assert_snapshot!(said);
}

#[test]
fn what_a_part_allows_is_allowed() {
    let part = "[3000]\n;od-gen: allow default-outside-limits because it is off at the start\nParameterName=Flow\n\
                DataType=0x0006\nAccessType=rw\nLowLimit=5\nDefaultValue=0\n";
    let first = family(RECIPE, part);
    let report = first.report();
    assert_eq!(first.said(&report), "");
    // Where a part states more of an object of the base, what either allows counts for both.
    let more = "[2001]\n;od-gen: allow default-outside-limits because a test asks for it\nDefaultValue=-100\n";
    let family = family(RECIPE, more);
    assert_eq!(family.said(&family.report()), "");
    let comment = "# od-gen: allow default-outside-limits because a test asks for it\n\n";
    let family = self::family(&format!("{comment}{RECIPE}"), "[2001]\nDefaultValue=-100\n");
    assert_eq!(family.said(&family.report()), "");
}

#[test]
fn the_example_of_the_readme_is_a_recipe() {
    let readme = include_str!("../../README.md");
    let (_, rest) = readme.split_once("```toml\n# pump.toml").unwrap();
    let text = rest.split("```").next().unwrap();
    let file: super::File = toml::from_str(text).unwrap();
    assert_eq!(file.part.len(), 1);
    assert_eq!(file.identity.len(), 1);
}
