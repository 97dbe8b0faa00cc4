//! Rules of recipes: a data sheet made of a base and parts.

use super::Rule;

pub(crate) const RULES: &[&Rule] = &[&SYNTAX, &PART, &OBJECT, &IDENTITY];

pub(crate) static SYNTAX: Rule = Rule::fatal(
    "recipe-syntax",
    "A recipe is TOML with the tables [base], [[part]], [identity] and [defaults].",
    "A base and a part have the keys eds, objects and remove. od-gen/README.md shows one.",
);

pub(crate) static PART: Rule = Rule::fatal(
    "recipe-part",
    "The base and the parts of a recipe can be read.",
    "Their paths are from the folder of the recipe. A recipe may be a part of another one, but not of itself.",
);

pub(crate) static OBJECT: Rule = Rule::fatal(
    "recipe-object",
    "What a recipe takes, removes or gives a default is there.",
    "Objects are named by index: 2050h, 2050h-205Fh, and one sub-index 2050h:3. What is removed was there before the part.",
);

pub(crate) static IDENTITY: Rule = Rule::fatal(
    "recipe-identity",
    "The identity of a recipe is vendor, product, revision and serial number.",
    "Each is a number or a text, or `$NAME` for that of the environment. It stands in DeviceInfo and in 1018h then.",
);
