//! A network as far as it has grown at a time.

use super::CrackNetwork;

impl CrackNetwork {
    /// Time of the last arrival, 0 where the network keeps no times.
    #[must_use]
    pub fn last_arrival(&self) -> f64 {
        self.data
            .segments
            .arrival()
            .map_or(0.0, |times| times.iter().copied().fold(0.0, f64::max))
    }

    /// The segments as far as they have grown at `time` (same unit as the arrival column):
    /// index and ends `[x0, y0, x1, y1]`, the last one up to the tip.
    ///
    /// A tip moves evenly from its departure to its arrival. Where the network keeps no
    /// departures, it departs when its parent arrives, at time 0 from an impact, and a crack
    /// that starts elsewhere appears whole at its arrival. Networks without times are always
    /// full-grown.
    pub fn grown_at(&self, time: f64) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        let segments = &self.data.segments;
        let arrival = segments.arrival();
        let departure = segments.departure();
        let start_of = move |idx: usize, times: &[f64]| -> f64 {
            if let Some(departure) = departure {
                return departure[idx];
            }
            if let Some(parent) = segments.parent.as_ref().and_then(|column| column[idx]) {
                return times[parent as usize];
            }
            let [x, y, ..] = self.ends(idx);
            #[expect(
                clippy::float_cmp,
                reason = "an impact is a node when it is the very same point"
            )]
            let at_impact = self
                .data
                .impacts
                .iter()
                .any(|impact| impact.x == x && impact.y == y);
            if at_impact { 0.0 } else { times[idx] }
        };
        (0..self.n_segments()).filter_map(move |idx| {
            let [x0, y0, x1, y1] = self.ends(idx);
            let Some(times) = arrival else {
                return Some((idx, [x0, y0, x1, y1]));
            };
            if time >= times[idx] {
                return Some((idx, [x0, y0, x1, y1]));
            }
            let start = start_of(idx, times);
            if time <= start {
                return None;
            }
            let grown = (time - start) / (times[idx] - start);
            Some((
                idx,
                [x0, y0, x0 + (x1 - x0) * grown, y0 + (y1 - y0) * grown],
            ))
        })
    }
}
