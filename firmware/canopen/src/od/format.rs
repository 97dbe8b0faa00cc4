//! Which generated dictionaries this crate reads.

/// What `od-gen` writes at the top of a dictionary: the format that it is in. One that this crate does not read ends the build here, and not with
/// errors all over the generated code. `FORMAT` of `od-gen` and the number here rise together.
#[doc(hidden)]
#[macro_export]
macro_rules! generated_by {
    (format 2) => {};
    (format $other:literal) => {
        ::core::compile_error!(::core::concat!(
            "this dictionary is in format ",
            $other,
            " of od-gen, and this version of canopen reads format 2: take versions of od-gen and canopen that belong together, and generate it anew"
        ));
    };
}
