//! A module for each bound object: what its numbers mean to the drive.

use cia402_parameters::Description;

use super::ALLOW_UNUSED;
use super::documentation::title;
use super::sites::Site;
use crate::bind::Meaning;

pub(super) fn write(all: &[(&Description, Vec<Site<'_>>)]) -> String {
    let mut out = String::new();
    for (parameter, sites) in all {
        for site in sites {
            if let Some((module, binding)) = site.module().zip(site.binding) {
                out += &format!("// {} is {}.\n", title(site.row), parameter.name);
                out += ALLOW_UNUSED;
                out += &format!("mod {module} {{\n{}}}\n\n", functions(&binding.meaning));
            }
        }
    }
    out
}

fn functions(meaning: &Meaning) -> String {
    match meaning {
        Meaning::Scale {
            numerator,
            denominator,
            offset,
        } => format!(
            "    use ::cia402::binding::Conversion;\n\n    \
             const CONVERSION: Conversion = Conversion::new({numerator}, {denominator}, {offset});\n\n    \
             pub(super) fn to_parameter(number: i64) -> Option<i64> {{\n        \
             Some(CONVERSION.to_parameter(number))\n    }}\n\n    \
             pub(super) fn to_object(number: i64) -> Option<i64> {{\n        \
             Some(CONVERSION.to_object(number))\n    }}\n"
        ),
        Meaning::Values(pairs) => {
            let there = pairs
                .iter()
                .map(|(object, parameter)| (*object, *parameter));
            let mut back: Vec<(i64, i64)> = pairs
                .iter()
                .map(|(object, parameter)| (*parameter, *object))
                .collect();
            // Of several numbers with one meaning the lowest is shown.
            back.sort_unstable();
            back.dedup_by_key(|(parameter, _)| *parameter);
            format!(
                "{}\n{}",
                values("to_parameter", there),
                values("to_object", back.into_iter())
            )
        }
    }
}

fn values(name: &str, pairs: impl Iterator<Item = (i64, i64)>) -> String {
    let arms: String = pairs
        .map(|(from, to)| format!("            {from} => Some({to}),\n"))
        .collect();
    format!(
        "    pub(super) fn {name}(number: i64) -> Option<i64> {{\n        match number {{\n{arms}            \
         _ => None,\n        }}\n    }}\n"
    )
}
