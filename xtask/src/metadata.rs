//! What `cargo metadata` says, as far as the chores need it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::Failure;
use crate::command::{cargo, line_of};

/// All packages of the workspace and those that they use.
#[derive(Debug, Clone)]
pub struct Metadata {
    /// The packages.
    pub packages: Vec<Package>,
    /// Where cargo builds.
    pub target_directory: PathBuf,
}

/// One package.
#[derive(Debug, Clone, Default)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Its licence expression.
    pub license: Option<String>,
    /// Where it comes from; `None` for a folder on this machine.
    pub source: Option<String>,
    /// Whether it is a member of the workspace.
    pub is_ours: bool,
    /// Its folder, relative to the workspace, with `/`; only for our own.
    pub folder: String,
    /// What its manifest asks for.
    pub dependencies: Vec<Dependency>,
    /// Its features that are on in this workspace.
    pub features: Vec<String>,
}

/// A line of `[dependencies]`, `[dev-dependencies]` or `[build-dependencies]`.
#[derive(Debug, Clone, Default)]
pub struct Dependency {
    /// Name of the package.
    pub name: String,
    /// Where it is looked for; `None` for a folder.
    pub source: Option<String>,
    /// When it is needed.
    pub kind: Kind,
    /// The features that are asked for.
    pub features: Vec<String>,
    /// Whether the default features are asked for, too.
    pub uses_default_features: bool,
}

/// When a dependency is needed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Kind {
    /// Always.
    #[default]
    Normal,
    /// For tests, examples and benches.
    Dev,
    /// For the build script.
    Build,
}

impl Metadata {
    /// Asks cargo.
    ///
    /// # Errors
    /// If cargo fails, e.g. because the lock file is stale.
    pub fn of_workspace(root: &Path) -> Result<Self, Failure> {
        let mut command = cargo(root, &["metadata", "--format-version", "1", "--locked"]);
        let line = line_of(&command);
        let output = command
            .output()
            .map_err(|cause| Failure::new(format!("{line}: {cause}")))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
            return Err(Failure::new(format!("{line}: {}", said.trim())));
        }
        let json = serde_json::from_slice(&output.stdout)
            .map_err(|cause| Failure::new(format!("{line}: {cause}")))?;
        Ok(Self::from_json(&json))
    }

    /// Our own packages, by folder.
    #[must_use]
    pub fn ours(&self) -> Vec<&Package> {
        let mut ours: Vec<_> = self.packages.iter().filter(|p| p.is_ours).collect();
        ours.sort_by(|a, b| a.folder.cmp(&b.folder));
        ours
    }

    fn from_json(json: &Value) -> Self {
        let root = text(&json["workspace_root"]);
        let members: Vec<&Value> = list(&json["workspace_members"]).collect();
        let package = |p: &Value| {
            let node = list(&json["resolve"]["nodes"]).find(|node| node["id"] == p["id"]);
            let manifest = text(&p["manifest_path"]);
            let folder = Path::new(&manifest)
                .parent()
                .and_then(|folder| folder.strip_prefix(&root).ok())
                .map(|folder| folder.to_string_lossy().replace('\\', "/"));
            Package {
                name: text(&p["name"]),
                version: text(&p["version"]),
                license: p["license"].as_str().map(str::to_owned),
                source: p["source"].as_str().map(str::to_owned),
                is_ours: members.contains(&&p["id"]),
                folder: folder.unwrap_or_default(),
                dependencies: list(&p["dependencies"]).map(dependency).collect(),
                features: node.map_or(Vec::new(), |node| {
                    list(&node["features"]).map(text).collect()
                }),
            }
        };
        Self {
            packages: list(&json["packages"]).map(package).collect(),
            target_directory: PathBuf::from(text(&json["target_directory"])),
        }
    }
}

fn dependency(d: &Value) -> Dependency {
    Dependency {
        name: text(&d["name"]),
        source: d["source"].as_str().map(str::to_owned),
        kind: match d["kind"].as_str() {
            Some("dev") => Kind::Dev,
            Some("build") => Kind::Build,
            _ => Kind::Normal,
        },
        features: list(&d["features"]).map(text).collect(),
        uses_default_features: d["uses_default_features"].as_bool().unwrap_or(true),
    }
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_kinds_and_resolved_features_are_read() {
        let json = serde_json::json!({
            "workspace_root": "/w", "target_directory": "/w/target", "workspace_members": ["a"],
            "packages": [{
                "id": "a", "name": "a", "version": "1.0.0", "license": "MIT", "source": null,
                "manifest_path": "/w/crates/a/Cargo.toml",
                "dependencies": [{
                    "name": "b", "source": "registry", "kind": "dev", "features": ["f"],
                    "uses_default_features": false,
                }],
            }],
            "resolve": { "nodes": [{ "id": "a", "features": ["default"] }] },
        });
        let metadata = Metadata::from_json(&json);
        let [package] = metadata.packages.as_slice() else {
            panic!("one package in, {} out", metadata.packages.len());
        };
        assert!(package.is_ours, "a member is ours");
        assert_eq!(package.folder, "crates/a", "folder in the workspace");
        assert_eq!(package.features, ["default"], "what the resolver turned on");
        assert_eq!(package.dependencies[0].kind, Kind::Dev, "kind");
        assert!(
            !package.dependencies[0].uses_default_features,
            "default features"
        );
    }
}
