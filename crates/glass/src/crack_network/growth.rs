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

    /// The time at which a share of the length of all cracks is there, in the unit of the arrival column; 0 for
    /// networks without times.
    ///
    /// Cracks of hours follow cracks of microseconds: even steps of time would show one or the other, even steps of
    /// length show both.
    #[must_use]
    pub fn time_of_length(&self, share: f64) -> f64 {
        let length_at = |time: f64| -> f64 {
            let length = |(_, [x0, y0, x1, y1]): (usize, [f64; 4])| {
                ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt()
            };
            self.grown_at(time).map(length).sum()
        };
        let last = self.last_arrival();
        if share >= 1.0 {
            return last;
        }
        let wanted = share * length_at(last);
        if length_at(0.0) >= wanted {
            return 0.0;
        }
        // The length only grows. Halved until nothing lies between.
        let (mut early, mut late) = (0.0, last);
        loop {
            let middle = 0.5 * (early + late);
            if middle <= early || middle >= late {
                break;
            }
            if length_at(middle) < wanted {
                early = middle;
            } else {
                late = middle;
            }
        }
        late
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
