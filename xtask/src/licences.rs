//! What we link must be free to use, come from crates.io, and not change our bytes.

use std::path::Path;

use spdx::{Expression, ParseMode};

use crate::Failure;
use crate::metadata::{Metadata, Package};

/// Licences that ask for no more than to be named.
const ALLOWED: [&str; 16] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "IJG",
    "ISC",
    "MIT",
    "MIT-0",
    "OFL-1.1",
    "Ubuntu-font-1.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// The licence of our own crates.
const OURS: &str = "MIT OR Apache-2.0";

/// The one place that packages come from.
const CRATES_IO: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Features that must stay off in the whole build: package, feature, reason.
const FORBIDDEN_FEATURES: [(&str, &str, &str); 1] =
    [("jpeg-encoder", "simd", "it changes the bytes of a JPEG")];

/// `cargo xtask licences`
///
/// # Errors
/// If a package breaks a rule.
pub fn run(root: &Path) -> Result<(), Failure> {
    let metadata = Metadata::of_workspace(root)?;
    Failure::from_findings(&findings(&metadata.packages), "packages break a rule")?;
    println!("licences: {} packages are fine", metadata.packages.len());
    Ok(())
}

fn findings(packages: &[Package]) -> Vec<String> {
    let mut findings = Vec::new();
    for package in packages {
        let Package { name, version, .. } = package;
        if let Some(why) = licence_finding(package) {
            findings.push(format!("{name} {version}: {why}"));
        }
        match &package.source {
            None if package.is_ours => {}
            Some(source) if source == CRATES_IO => {}
            source => {
                let source = source.as_deref().unwrap_or("a folder");
                findings.push(format!("{name} {version} comes from {source}"));
            }
        }
        for (_, feature, why) in FORBIDDEN_FEATURES.iter().filter(|rule| rule.0 == name) {
            if package.features.iter().any(|on| on == feature) {
                findings.push(format!(
                    "{name} {version}: feature `{feature}` is on; {why}"
                ));
            }
        }
        for dependency in package.dependencies.iter().filter(|_| package.is_ours) {
            for (_, feature, why) in FORBIDDEN_FEATURES
                .iter()
                .filter(|rule| rule.0 == dependency.name)
            {
                if dependency.features.iter().any(|on| on == feature) {
                    findings.push(format!(
                        "{name} turns on `{feature}` of {}; {why}",
                        dependency.name
                    ));
                }
            }
        }
    }
    findings
}

fn licence_finding(package: &Package) -> Option<String> {
    let Some(licence) = &package.license else {
        return Some("names no licence".to_owned());
    };
    if package.is_ours {
        return (licence != OURS).then(|| format!("licence is {licence:?}; ours is {OURS:?}"));
    }
    match Expression::parse_mode(licence, MODE) {
        Err(error) => Some(format!("licence {licence:?} is not SPDX: {}", error.reason)),
        Ok(expression) => {
            let is_allowed = expression
                .evaluate(|requirement| ALLOWED.contains(&requirement.to_string().as_str()));
            (!is_allowed).then(|| format!("licence {licence:?} is not on the allow-list"))
        }
    }
}

/// SPDX, and the `/` for `OR` of old manifests.
const MODE: ParseMode = ParseMode {
    allow_slash_as_or_operator: true,
    ..ParseMode::STRICT
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metadata::Dependency;

    fn package(license: Option<&str>) -> Package {
        Package {
            name: "example".to_owned(),
            version: "1.2.3".to_owned(),
            license: license.map(str::to_owned),
            source: Some(CRATES_IO.to_owned()),
            ..Package::default()
        }
    }

    #[test]
    fn licence_expressions() {
        let check = |licence: Option<&str>, expected: &[&str]| {
            assert_eq!(findings(&[package(licence)]), expected, "{licence:?}");
        };
        for fine in [
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0-only OR MIT",
            "(MIT OR Apache-2.0) AND IJG",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            check(Some(fine), &[]);
        }
        check(
            Some("GPL-3.0-only"),
            &["example 1.2.3: licence \"GPL-3.0-only\" is not on the allow-list"],
        );
        check(
            Some("MIT AND MPL-2.0"),
            &["example 1.2.3: licence \"MIT AND MPL-2.0\" is not on the allow-list"],
        );
        check(None, &["example 1.2.3: names no licence"]);
        assert!(
            findings(&[package(Some("free for all"))])[0].contains("is not SPDX"),
            "words are no licence"
        );
    }

    #[test]
    fn our_crates_carry_both_licences() {
        let ours = Package {
            is_ours: true,
            source: None,
            ..package(Some("MIT"))
        };
        assert_eq!(
            findings(&[ours]),
            ["example 1.2.3: licence is \"MIT\"; ours is \"MIT OR Apache-2.0\""],
            "MIT alone"
        );
    }

    #[test]
    fn packages_from_elsewhere_are_found() {
        for (source, expected) in [
            (
                Some("git+https://example.org/a"),
                "example 1.2.3 comes from git+https://example.org/a",
            ),
            (None, "example 1.2.3 comes from a folder"),
        ] {
            let package = Package {
                source: source.map(str::to_owned),
                ..package(Some("MIT"))
            };
            assert_eq!(findings(&[package]), [expected], "{source:?}");
        }
    }

    #[test]
    fn simd_of_jpeg_encoder_is_found_in_the_build_and_in_the_manifest() {
        let built = Package {
            name: "jpeg-encoder".to_owned(),
            features: vec!["simd".to_owned()],
            ..package(Some("MIT"))
        };
        let asks = Package {
            is_ours: true,
            source: None,
            dependencies: vec![Dependency {
                name: "jpeg-encoder".to_owned(),
                features: vec!["simd".to_owned()],
                ..Dependency::default()
            }],
            ..package(Some(OURS))
        };
        let found = findings(&[built, asks]);
        assert_eq!(found.len(), 2, "{found:?}");
    }
}
