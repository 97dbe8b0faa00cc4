//! Large structs, copied field by field.
//!
//! Of a struct of more than 64 bytes the compiler makes a call of `memcpy`, which takes four instructions for a word on this processor;
//! of its fields it makes loads and stores of several registers at once. That counts where a lock is held.

/// Copies every field of a struct. A field that is left out does not compile.
macro_rules! copy_fields {
    ($kind:ident { $($(#[$meta:meta])? $field:ident),+ $(,)? }, $from:expr => $to:expr) => {{
        let $kind { $($(#[$meta])? $field),+ } = $from;
        let to = $to;
        $($(#[$meta])? { to.$field = *$field; })+
    }};
}

pub(crate) use copy_fields;
