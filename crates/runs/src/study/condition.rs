//! What is done to the glass, once for each condition of a study.

use std::collections::BTreeSet;

use starbreak_seed::Seed;

use starbreak::{Recipe, RecipeError};

/// One way of breaking the glass, applied to all images.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Its name, which is that of its folder: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// The family of cracks, over which mPC averages: a preset, or the name of a recipe.
    pub family: String,
    /// 1 to 5, of presets that were scaled.
    pub severity: Option<u8>,
    /// Seed of the cracks.
    pub seed: Seed,
    /// The recipe.
    pub recipe: Recipe,
    /// Whether the glass is that of the study's photographs; its cracks are simulated otherwise.
    pub is_photographed: bool,
}

/// A family of cracks before it is scaled and drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Family {
    /// A preset by its name, scaled by each severity.
    Preset(String),
    /// A recipe with its name; severities do not scale it.
    Recipe(String, Box<Recipe>),
    /// Photographs of broken glass under this name, lit by the optics of a recipe; severities do not
    /// scale them.
    Photos(String, Box<Recipe>),
}

/// All conditions: each family at each severity with each seed, in this order.
///
/// Without severities a preset stands as it is. `adjust` is applied to each recipe, such as
/// for a camera or for single keys.
///
/// # Errors
/// [`RecipeError`] of a preset that there is not, of a severity out of range, of `adjust`, and where
/// two conditions would have one name.
pub fn conditions(
    families: &[Family],
    severities: &[u8],
    seeds: &[Seed],
    adjust: &dyn Fn(&mut Recipe) -> Result<(), RecipeError>,
) -> Result<Vec<Condition>, RecipeError> {
    let mut all = Vec::new();
    let mut names = BTreeSet::new();
    for family in families {
        let (name, scaled) = match family {
            Family::Preset(name) if severities.is_empty() => {
                (name, vec![(None, Recipe::preset(name)?)])
            }
            Family::Preset(name) => {
                let at = |severity: &u8| Ok((Some(*severity), Recipe::preset_at(name, *severity)?));
                let scaled: Result<Vec<_>, RecipeError> = severities.iter().map(at).collect();
                (name, scaled?)
            }
            Family::Recipe(name, recipe) | Family::Photos(name, recipe) => {
                (name, vec![(None, (**recipe).clone())])
            }
        };
        let is_photographed = matches!(family, Family::Photos(..));
        for (severity, mut recipe) in scaled {
            adjust(&mut recipe)?;
            for seed in seeds {
                let mut folder = folder_name(name);
                if let Some(severity) = severity {
                    folder = format!("{folder}-severity-{severity}");
                }
                folder = format!("{folder}-seed-{}", seed.0);
                if !names.insert(folder.clone()) {
                    return Err(RecipeError::Twice { what: folder });
                }
                all.push(Condition {
                    name: folder,
                    family: name.clone(),
                    severity,
                    seed: *seed,
                    recipe: recipe.clone(),
                    is_photographed,
                });
            }
        }
    }
    Ok(all)
}

/// A name that any file system takes, never empty and never hidden.
#[must_use]
pub fn folder_name(name: &str) -> String {
    let plain: String = name
        .chars()
        .map(|c| match c {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '.' => c,
            _ => '_',
        })
        .take(100)
        .collect();
    match plain.trim_start_matches('.') {
        "" => "unnamed".to_owned(),
        name => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn families_times_severities_times_seeds() {
        let families = [
            Family::Preset("paper".to_owned()),
            Family::Recipe(
                "my glass/1".to_owned(),
                Box::new(Recipe::preset("tempered-cover").unwrap()),
            ),
            Family::Photos(
                "photos".to_owned(),
                Box::new(Recipe::preset("paper").unwrap()),
            ),
        ];
        let all = conditions(&families, &[1, 5], &[Seed(0), Seed(7)], &|_| Ok(())).unwrap();
        let names: Vec<&str> = all
            .iter()
            .map(|condition| condition.name.as_str())
            .collect();
        let expected = [
            "paper-severity-1-seed-0",
            "paper-severity-1-seed-7",
            "paper-severity-5-seed-0",
            "paper-severity-5-seed-7",
            "my_glass_1-seed-0",
            "my_glass_1-seed-7",
            "photos-seed-0",
            "photos-seed-7",
        ];
        assert_eq!(
            names, expected,
            "neither recipes nor photographs are scaled"
        );
        let n_photographed = all.iter().filter(|one| one.is_photographed).count();
        assert_eq!(n_photographed, 2, "the last two");
    }

    #[test]
    fn no_two_conditions_share_a_name() {
        let paper = Family::Preset("paper".to_owned());
        let mild = || {
            Family::Recipe(
                "mild".to_owned(),
                Box::new(Recipe::preset("paper").unwrap()),
            )
        };
        let none = |_: &mut Recipe| Ok(());
        for (families, severities, seeds) in [
            (vec![paper.clone(), paper.clone()], vec![], vec![Seed(0)]),
            (vec![paper.clone()], vec![1, 1], vec![Seed(0)]),
            (vec![paper], vec![1], vec![Seed(0), Seed(0)]),
            (vec![mild(), mild()], vec![], vec![Seed(0)]),
        ] {
            let refused = conditions(&families, &severities, &seeds, &none).unwrap_err();
            assert!(refused.to_string().contains("twice"), "{refused}");
        }
        for (name, expected) in [("..", "unnamed"), ("a/../b", "a_.._b"), ("", "unnamed")] {
            assert_eq!(folder_name(name), expected, "{name:?}");
        }
    }

    #[test]
    fn what_is_set_is_set_in_all() {
        let all = conditions(
            &[Family::Preset("paper".to_owned())],
            &[2, 3],
            &[Seed(0)],
            &|recipe| recipe.set("output.quality=77"),
        )
        .unwrap();
        assert!(
            all.iter()
                .all(|condition| condition.recipe.settings().unwrap().output.quality == 77),
            "each"
        );
    }
}
