//! Glass as a solid and as a dielectric: each constant beside the place it was read in.

use serde::Deserialize;

/// One measured constant, in SI units, with its source.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Property {
    /// The value in the unit that the property's name carries.
    pub value: f64,
    /// Key of an entry in `data/literature.bib`.
    pub source: String,
    /// Spread in the literature and conditions of measurement.
    pub note: String,
}

/// An isotropic, linear-elastic, brittle glass.
///
/// # Limits
/// Room temperature, short loads: no viscoelasticity and no slow (humid) crack growth.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// What a glazier calls it.
    pub name: String,
    /// Young's modulus E, Pa.
    pub young_modulus_pa: Property,
    /// Poisson's ratio ν, in (-1, 0.5).
    pub poisson_ratio: Property,
    /// Density ρ, kg/m³.
    pub density_kg_m3: Property,
    /// Mode-I fracture toughness `K_IC`, Pa·√m.
    pub fracture_toughness_pa_sqrt_m: Property,
    /// Index of refraction at 589 nm, relative to air.
    pub ior: Property,
}

/// Why a material was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// The text is not a material file.
    #[error("not a material file: {0}")]
    Parse(#[from] serde_json::Error),
    /// A constant lies outside what any glass can have.
    #[error("material `{material}`: {property} = {value} is outside {range}")]
    OutOfRange {
        /// Name of the material.
        material: String,
        /// Name of the constant, with its unit.
        property: &'static str,
        /// What was given.
        value: f64,
        /// What is possible.
        range: &'static str,
    },
}

impl Material {
    /// Annealed soda-lime float glass, the glass of windscreens and windows.
    ///
    /// # Errors
    /// Never for the embedded file; the type says so because [`Material::from_json`] does.
    ///
    /// # Example
    /// ```
    /// let glass = starbreak_glass::Material::soda_lime()?;
    /// assert!((glass.fracture_energy_j_m2() - 8.0).abs() < 0.1);
    /// # Ok::<(), starbreak_glass::MaterialError>(())
    /// ```
    pub fn soda_lime() -> Result<Self, MaterialError> {
        Self::from_json(include_str!("../data/soda_lime.json"))
    }

    /// A material from the text of a file like `data/soda_lime.json`.
    ///
    /// # Errors
    /// [`MaterialError`] when the text does not parse or a constant is unphysical.
    pub fn from_json(text: &str) -> Result<Self, MaterialError> {
        let material: Self = serde_json::from_str(text)?;
        let checks: [(&'static str, &Property, f64, f64, &'static str); 5] = [
            (
                "young_modulus_pa",
                &material.young_modulus_pa,
                1e9,
                1e12,
                "1e9..1e12 Pa",
            ),
            (
                "poisson_ratio",
                &material.poisson_ratio,
                -1.0,
                0.5,
                "-1..0.5",
            ),
            (
                "density_kg_m3",
                &material.density_kg_m3,
                500.0,
                20e3,
                "500..20000 kg/m³",
            ),
            (
                "fracture_toughness_pa_sqrt_m",
                &material.fracture_toughness_pa_sqrt_m,
                1e4,
                1e8,
                "1e4..1e8 Pa·√m",
            ),
            ("ior", &material.ior, 1.0, 3.0, "1..3"),
        ];
        for (property, given, low, high, range) in checks {
            if !(given.value > low && given.value < high) {
                return Err(MaterialError::OutOfRange {
                    material: material.name.clone(),
                    property,
                    value: given.value,
                    range,
                });
            }
        }
        Ok(material)
    }

    /// Fracture energy Γ = `K_IC`²/E, J/m² \[Irwin1957\].
    #[must_use]
    pub fn fracture_energy_j_m2(&self) -> f64 {
        let toughness = self.fracture_toughness_pa_sqrt_m.value;
        toughness * toughness / self.young_modulus_pa.value
    }

    /// Speed of longitudinal waves in a thin bar, √(E/ρ), m/s.
    #[must_use]
    pub fn bar_wave_speed_m_s(&self) -> f64 {
        (self.young_modulus_pa.value / self.density_kg_m3.value).sqrt()
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn soda_lime_gives_the_published_derived_constants() {
        let glass = Material::soda_lime().unwrap();
        assert!(
            (glass.fracture_energy_j_m2() - 8.0).abs() < 0.1,
            "Γ of glass is 8 J/m²"
        );
        assert!(
            (glass.bar_wave_speed_m_s() - 5290.0).abs() < 5.0,
            "c of glass is 5290 m/s"
        );
    }

    #[test]
    fn every_source_is_in_the_bibliography() {
        let bib = include_str!("../data/literature.bib");
        let glass = Material::soda_lime().unwrap();
        for property in [
            &glass.young_modulus_pa,
            &glass.poisson_ratio,
            &glass.density_kg_m3,
            &glass.fracture_toughness_pa_sqrt_m,
            &glass.ior,
        ] {
            assert!(
                bib.contains(&format!("{{{},", property.source)),
                "{property:?} has no source"
            );
        }
    }

    #[test]
    fn an_unphysical_constant_is_refused_by_name_and_value() {
        let text = include_str!("../data/soda_lime.json").replace("0.22", "0.7");
        let message = Material::from_json(&text).unwrap_err().to_string();
        assert!(message.contains("poisson_ratio = 0.7"), "{message}");
    }
}
