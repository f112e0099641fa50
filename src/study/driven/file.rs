//! Branches of driven orbits as files, with their scene.

use crate::{
    error::{Error, Result},
    orbits::{BifurcationKind, DrivenBranch, DrivenSetting},
    output::{Archive, SETTINGS},
    scene::{Scene, SceneFile},
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What the file has of the setting.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Source {
    /// The scene as TOML.
    scene: String,
    turns: u32,
}

impl Source {
    fn scene(&self) -> Result<Scene> {
        SceneFile::parse(&self.scene, SETTINGS).and_then(Scene::build)
    }
}

/// The bytes of the file for a branch of this scene.
///
/// # Errors
/// Errors of the archive writer.
pub fn driven_branch_npz(scene: &Scene, branch: &DrivenBranch) -> Result<Vec<u8>> {
    let source = Source { scene: scene.file().to_toml(), turns: branch.setting.turns() };
    branch.npz_of(source, Vec::new())
}

/// Reads a branch and its scene: the orbits have the bits they had when written; their Newton steps
/// are not in the file.
///
/// # Errors
/// A file that cannot be read; [`Error::Content`], with the place and the rule, for a file with
/// another structure or version, or with numbers outside their rules.
pub fn load_driven_branch(path: &Path) -> Result<(Scene, DrivenBranch)> {
    let file = Archive::read(path)?;
    let (scene, branch) = driven_branch_from_archive(&file)?;
    Ok((scene, branch.verified(&file)?))
}

/// Reads a branch and its scene from an archive, with all checks that need no integration.
///
/// [`load_driven_branch`] checks in addition that the orbits return.
///
/// # Errors
/// As [`load_driven_branch`].
pub fn driven_branch_from_archive(file: &Archive) -> Result<(Scene, DrivenBranch)> {
    let setting = |source: &Source| DrivenSetting::new(source.scene()?.chain(), source.turns);
    let (source, branch) = DrivenBranch::read(file, setting)?;
    if branch.birth == Some(BifurcationKind::PeriodDoubling) && !source.turns.is_multiple_of(2) {
        let why = Error::parameter("turns", source.turns, "even after a period doubling");
        return Err(file.refused(SETTINGS, why.to_string()));
    }
    Ok((source.scene()?, branch))
}
