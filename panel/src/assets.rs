//! The page, as it lies in `panel/page`: in the program itself, so that there is nothing to install.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Its path in the address.
    pub path: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// What is in it.
    pub bytes: &'static [u8],
}

macro_rules! assets {
    ($($file:literal $kind:literal),* $(,)?) => {
        /// All of them.
        pub const ASSETS: &[Asset] = &[$(Asset {
            path: concat!("/", $file),
            kind: $kind,
            bytes: include_bytes!(concat!("../page/", $file)),
        }),*];
    };
}

assets!(
    "index.html" "text/html; charset=utf-8",
    "style.css" "text/css; charset=utf-8",
    "icon.svg" "image/svg+xml",
    "app.js" "text/javascript; charset=utf-8",
    "connection.js" "text/javascript; charset=utf-8",
    "element.js" "text/javascript; charset=utf-8",
    "bus.js" "text/javascript; charset=utf-8",
    "drive.js" "text/javascript; charset=utf-8",
    "chart.js" "text/javascript; charset=utf-8",
    "machine.js" "text/javascript; charset=utf-8",
    "objects.js" "text/javascript; charset=utf-8",
    "homing.js" "text/javascript; charset=utf-8",
    "pdos.js" "text/javascript; charset=utf-8",
    "scope.js" "text/javascript; charset=utf-8",
    "tuning.js" "text/javascript; charset=utf-8",
    "ring.js" "text/javascript; charset=utf-8",
    "log.js" "text/javascript; charset=utf-8",
    // Of others, as it was published.
    "uplot/uPlot.esm.js" "text/javascript; charset=utf-8",
    "uplot/uPlot.min.css" "text/css; charset=utf-8",
    "uplot/LICENSE" "text/plain; charset=utf-8",
);

/// The file at this path; `/` is the page.
pub fn find(path: &str) -> Option<Asset> {
    let path = if path == "/" { "/index.html" } else { path };
    ASSETS.iter().find(|asset| asset.path == path).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_whole_and_loads_nothing_from_elsewhere() {
        for asset in ASSETS {
            let text = std::str::from_utf8(asset.bytes).unwrap();
            // What others have written loads nothing: the policy of the server sees to it, and the tests in the browser.
            if asset.path.starts_with("/uplot/") {
                assert!(!text.contains("import ") && !text.contains("@import"));
                continue;
            }
            for (at, _) in text.match_indices("//") {
                let before = text[..at].chars().last();
                let address: String = text[at..].chars().take(40).collect();
                // A comment, the name of the SVG language, or the panel itself.
                let known = ["//www.w3.org/2000/svg", "//${location.host}/"];
                let is_known = known.iter().any(|known| address.starts_with(known));
                let is_fine = before != Some(':') || is_known;
                assert!(is_fine, "{}: {address}", asset.path);
            }
            // What a module imports is there.
            for import in text.split("from \"./").skip(1) {
                let file = import.split('"').next().unwrap();
                assert!(
                    find(&format!("/{file}")).is_some(),
                    "{}: {file}",
                    asset.path
                );
            }
        }
        assert_eq!(find("/").unwrap().path, "/index.html");
        assert!(find("/../Cargo.toml").is_none());
    }
}
