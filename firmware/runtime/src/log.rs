//! Logs, on a host that takes them by `defmt`.

/// Something failed: the words, and what it says of itself.
macro_rules! error {
    ($words:literal, $error:expr) => {{
        #[cfg(feature = "defmt")]
        defmt::error!($words, defmt::Display2Format(&$error));
        let _ = $error;
    }};
}

/// Something to know: the words with a format for each number.
macro_rules! info {
    ($words:literal $(, $number:expr)*) => {{
        #[cfg(feature = "defmt")]
        defmt::info!($words $(, $number)*);
        $(let _ = $number;)*
    }};
}
