use starbreak::Recipe;

use crate::Vocabulary;

/// Words of a recipe, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "schema = 1\n",
    "[[impact]]\n",
    "[impact]\n",
    "[fracture]\n",
    "[camera]\n",
    "focus_distance_m = ",
    "camera.pixel_pitch_um=",
    "[optics]\n",
    "optics.model=\"paper\"\n",
    "optics.model=physical\n",
    "sky_zenith = [0.1, 0.2, 0.3]\n",
    "= \"auto\"\n",
    "[output]\n",
    "position = [0.5, 1.0]\n",
    "= \"random\"\n",
    "direction_deg = ",
    "impact = [[\"random\", 1.0, \"random\"]]\n",
    "light_intensity = \"image-mean\"\n",
    "nan",
    "inf",
    "-0.0",
    "1e308",
    "9223372036854775807",
    "4294967296",
    "1979-05-27T07:32:00Z",
    "{ }",
    "[]",
    "\"\"\"",
    "\\u0000",
    "\u{feff}",
    "\r\n",
    "impact.0.force=",
    "fracture.particles=",
    "fracture.model=\"paper\"\n",
    "fracture.model=physics\n",
    "[glass]\n",
    "glass.kind=cover\n",
    "glass.width_mm=",
    "[long_crack]\n",
    "long_crack.spot=",
    "speed_m_s = ",
];

/// A recipe that parses is written as TOML that parses to the same recipe. Every line is also
/// tried as an override of a preset of each model: it may be refused, and then changes nothing; messages
/// are one printable line.
///
/// # Panics
/// If the input is a finding.
pub fn recipe(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    match Recipe::parse("fuzz.toml", text) {
        Ok(recipe) => survives_writing(&recipe),
        Err(error) => is_one_line(&error.to_string()),
    }
    for name in ["paper", "windshield-long-crack"] {
        let Ok(preset) = Recipe::preset(name) else {
            panic!("the preset does not parse");
        };
        for line in text.lines() {
            let mut recipe = preset.clone();
            match recipe.set(line) {
                Ok(()) => survives_writing(&recipe),
                Err(error) => {
                    is_one_line(&error.to_string());
                    assert_eq!(recipe, preset, "a refused --set changed the recipe");
                }
            }
        }
    }
}

fn survives_writing(recipe: &Recipe) {
    assert!(
        recipe.settings().is_ok(),
        "a recipe was accepted that has no settings"
    );
    for written in [recipe.to_toml(), recipe.to_commented_toml()] {
        match Recipe::parse("written.toml", &written) {
            Ok(again) => assert_eq!(&again, recipe, "written and read again:\n{written}"),
            Err(error) => panic!("does not read what it wrote: {error}\n{written}"),
        }
    }
}

fn is_one_line(message: &str) {
    assert!(
        !message.contains(char::is_control),
        "a message that is not one printable line: {message:?}"
    );
}
