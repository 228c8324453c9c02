//! What is wrong with the camera behind the glass.

use std::borrow::Cow;

use starbreak_optics::lens_faults::LensFaults;
use starbreak_sensor::Sensor;

/// The faults of lens, sensor and link, in the order in which light meets them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CameraFaults {
    /// Those of the lens.
    pub lens: LensFaults,
    /// Those of the sensor and of what comes after it.
    pub sensor: Sensor,
}

impl CameraFaults {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lens.faults().is_empty() && self.sensor.faults().is_empty()
    }

    /// With the faults alone that have begun at a time of a clip, s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Cow<'_, Self> {
        match (self.lens.at(time_s), self.sensor.at(time_s)) {
            (Cow::Borrowed(_), Cow::Borrowed(_)) => Cow::Borrowed(self),
            (lens, sensor) => Cow::Owned(Self {
                lens: lens.into_owned(),
                sensor: sensor.into_owned(),
            }),
        }
    }

    /// The times of a clip at which faults begin, s.
    pub fn onsets_s(&self) -> impl Iterator<Item = f64> + '_ {
        let lens = self.lens.faults().iter().map(|(onset_s, _)| *onset_s);
        let sensor = self.sensor.faults().iter().map(|(onset_s, _)| *onset_s);
        lens.chain(sensor)
    }
}
