//! When the packets of a clip are shown, by the lines of ffmpeg's `framecrc`.

use super::Fraction;

/// When the packets of a clip are shown, ticks, sorted.
#[derive(Debug, Default)]
pub(super) struct PacketTimes {
    pub(super) time_base: Option<Fraction>,
    /// When they are shown; once sorted, when they are decoded if not all say when they are shown.
    pub(super) ticks: Vec<i64>,
    decoded_ticks: Vec<i64>,
}

/// What ffmpeg writes where a packet has no such time.
const NO_TICKS: i64 = i64::MIN;

impl PacketTimes {
    /// `#tb 0: 1/30000`, or `0, dts, pts, duration, size, checksum, …`.
    pub(super) fn read_line(&mut self, line: &str) {
        if let Some(base) = line.strip_prefix("#tb 0: ") {
            self.time_base = base
                .trim()
                .split_once('/')
                .and_then(|(above, below)| Fraction::new(above.parse().ok()?, below.parse().ok()?));
        } else if !line.starts_with('#') {
            // Other streams are the audio.
            let Some(columns) = line.strip_prefix("0,") else {
                return;
            };
            let mut columns = columns.split(',').map(|column| column.trim().parse());
            if let (Some(Ok(decoded)), Some(Ok(shown))) = (columns.next(), columns.next()) {
                self.decoded_ticks.push(decoded);
                self.ticks.push(shown);
            }
        }
    }

    /// Puts the packets in order. AVI and bare streams do not say of all when they are shown; then
    /// they are decoded at the rate at which they are shown.
    pub(super) fn sort(&mut self) {
        if self.ticks.contains(&NO_TICKS) {
            self.ticks = std::mem::take(&mut self.decoded_ticks);
            self.ticks.retain(|ticks| *ticks != NO_TICKS);
        }
        self.ticks.sort_unstable();
    }

    pub(super) fn span_s(&self, time_base: Fraction) -> f64 {
        match (self.ticks.first(), self.ticks.last()) {
            (Some(first), Some(last)) => time_base.seconds(last - first),
            _ => 0.0,
        }
    }

    /// Frames per second over the whole clip, to a thousandth.
    pub(super) fn mean_rate(&self, time_base: Fraction) -> Option<Fraction> {
        let span_s = self.span_s(time_base);
        let n_steps = u32::try_from(self.ticks.len()).ok()?.checked_sub(1)?;
        let thousandths = (f64::from(n_steps) / span_s * 1e3).round();
        if !(1.0..=1e6).contains(&thousandths) {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and a million"
        )]
        let thousandths = thousandths as u32;
        Fraction::new(thousandths, 1000)
    }

    /// Whether each frame comes when the rate says, up to a tick of the clock.
    pub(super) fn has_constant_rate(&self, time_base: Fraction, rate: Fraction) -> bool {
        let step_s = 1.0 / rate.value();
        let tick_s = time_base.value();
        let Some(first) = self.ticks.first() else {
            return true;
        };
        (0_u32..).zip(&self.ticks).all(|(k, ticks)| {
            let off_s = time_base.seconds(ticks - first) - f64::from(k) * step_s;
            off_s.abs() <= 1.01 * tick_s
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(lines: &str) -> PacketTimes {
        let mut times = PacketTimes::default();
        for line in lines.lines() {
            times.read_line(line);
        }
        times.sort();
        times
    }

    #[test]
    fn packets_are_counted_and_put_in_order() {
        let times = times(
            "#tb 0: 1/1000\n#sar 0: 1/1\n0,  -33,  0, 33, 9, 0xab\n0, 0, 67, 33, 9, 0xcd, F=0x0\n0, 33, 33, 33, 9, 0xef",
        );
        assert_eq!(times.ticks, [0, 33, 67], "in the order of showing");
        let (Some(base), Some(rate)) = (times.time_base, Fraction::new(30, 1)) else {
            panic!("no clock");
        };
        assert!(times.has_constant_rate(base, rate), "ms of 30 per second");
        assert_eq!(
            times.mean_rate(base),
            Fraction::new(29_851, 1000),
            "2 / 67 ms"
        );
    }

    #[test]
    fn packets_that_do_not_say_when_they_are_shown_count_as_they_are_decoded() {
        let times = times(
            "#tb 0: 1/25\n#tb 1: 1/44100\n0, 0, -9223372036854775808, 1, 9, 0xab\n1, 0, 0, 1152, 9, 0xef\n\
             0, 1, 3, 1, 9, 0xab, F\n0, 2, 2, 1, 9, 0xcd, F=0x0\n0, 3, -9223372036854775808, 1, 9, 0xab, F",
        );
        assert_eq!(times.ticks, [0, 1, 2, 3], "of the video alone");
        let (Some(base), Some(rate)) = (times.time_base, Fraction::new(25, 1)) else {
            panic!("no clock");
        };
        assert!(times.has_constant_rate(base, rate), "25 per second");
    }

    #[test]
    fn a_gap_is_no_constant_rate() {
        let times =
            times("#tb 0: 1/1000\n0, 0, 0, 33, 9, 0\n0, 33, 33, 33, 9, 0\n0, 99, 99, 33, 9, 0");
        let (Some(base), Some(rate)) = (times.time_base, Fraction::new(30, 1)) else {
            panic!("no clock");
        };
        assert!(!times.has_constant_rate(base, rate), "a frame is missing");
    }
}
