//! Scenes: any text gives a scene that can be run, or an error with file and rule on one line.

#![no_main]

use hertzchain::scene::{Initial, Scene, SceneFile};
use libfuzzer_sys::{Corpus, fuzz_target};

/// Largest number of sites; longer chains take more time and test nothing else.
const MOST_SITES: usize = 200;
const MOST_RECORDED: usize = 1_000_000;

fuzz_target!(|text: &str| -> Corpus {
    let file = match SceneFile::parse(text, "fuzz.toml") {
        Ok(file) => file,
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("scene fuzz.toml: ") && message.lines().count() == 1, "{message}");
            return Corpus::Keep;
        }
    };
    // The scene, written and read again, is the same.
    let written = file.to_toml();
    let again = SceneFile::parse(&written, "again.toml").expect("what was written is a scene");
    assert_eq!(written, again.to_toml());
    // Absurd sizes are refused before memory is allocated; large but allowed sizes are left out
    // here. Profiles of breathers are computed with many digits, which takes long.
    if (MOST_SITES..=100_000_000).contains(&file.chain.sites) || matches!(file.initial, Initial::BrightBreather { .. })
    {
        return Corpus::Reject;
    }
    assert!(file.record.samples.is_none_or(|samples| samples <= MOST_RECORDED) || Scene::build(file.clone()).is_err());
    match Scene::build(file) {
        Ok(scene) => {
            assert!(scene.initial().as_slice().iter().all(|value| value.is_finite()));
            assert!(scene.end().is_finite() && scene.end() > 0.0 && scene.period().is_finite() && scene.period() > 0.0);
            assert!(scene.strains(scene.initial().as_slice()).iter().all(|x| !x.is_nan()));
            let _ = scene.plan(true);
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
    Corpus::Keep
});
