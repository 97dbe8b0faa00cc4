//! Who may talk to the panel: pages that it has served itself, and beyond this computer those who know its token.
//!
//! A page of somebody else can open a WebSocket to this computer; its Origin gives it away. A name that somebody else owns can be
//! made to mean this computer (DNS rebinding); so the panel answers to addresses, `localhost`, and the name it was told to listen on.

use std::net::IpAddr;

/// Whether the page that asks is one of the panel's own. `listen` is the host that a person has named.
pub fn is_own(origin: Option<&str>, host: Option<&str>, listen: &str) -> bool {
    let (Some(origin), Some(host)) = (origin, host) else {
        return false;
    };
    let name = host_name(host);
    let is_address = name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok();
    let is_known = is_address || name == "localhost" || name == host_name(listen);
    is_known && origin.strip_prefix("http://") == Some(host)
}

/// `host:port` without the port.
fn host_name(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        _ => host,
    }
}

/// Whether a query has the token in it. How long it takes tells nothing about how much of it is right.
pub fn has_token(query: Option<&str>, token: &str) -> bool {
    let mut given = query.unwrap_or_default().split('&');
    let given = given
        .find_map(|part| part.strip_prefix("token="))
        .unwrap_or_default();
    let pairs = given.bytes().zip(token.bytes());
    let difference = pairs.fold(0, |sum, (a, b)| sum | (a ^ b));
    given.len() == token.len() && difference == 0
}

/// A token that nobody guesses: 128 random bits.
///
/// # Errors
/// If this computer has no random numbers.
pub fn new_token() -> Result<String, String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_the_panel_are_heard() {
        let is = |origin, host| is_own(origin, host, "bench:8402");
        assert!(is(Some("http://127.0.0.1:8402"), Some("127.0.0.1:8402")));
        assert!(is(Some("http://localhost:8402"), Some("localhost:8402")));
        assert!(is(Some("http://[::1]:8402"), Some("[::1]:8402")));
        assert!(is(Some("http://bench:8402"), Some("bench:8402")));
        for (origin, host) in [
            (None, Some("127.0.0.1:8402")),
            (Some("http://127.0.0.1:8402"), None),
            (Some("null"), Some("127.0.0.1:8402")),
            (Some("http://evil.example"), Some("127.0.0.1:8402")),
            (Some("https://127.0.0.1:8402"), Some("127.0.0.1:8402")),
            (Some("http://127.0.0.1:9000"), Some("127.0.0.1:8402")),
            (Some("http://evil.example:8402"), Some("evil.example:8402")),
        ] {
            assert!(!is(origin, host), "{origin:?} {host:?}");
        }
    }

    #[test]
    fn a_token_is_known_or_not() {
        let token = new_token().unwrap();
        assert_eq!(token.len(), 32);
        assert_ne!(token, new_token().unwrap());
        assert!(has_token(Some(&format!("token={token}")), &token));
        assert!(has_token(Some(&format!("a=b&token={token}")), &token));
        for wrong in [
            "",
            "token=",
            &format!("token={}", &token[1..]),
            &format!("token={token}0"),
        ] {
            assert!(!has_token(Some(wrong), &token), "{wrong}");
        }
        assert!(!has_token(None, &token));
    }
}
