//! What stands before the glass at the bottom of a frame.

use crate::OpticsError;

/// Most rows that are given.
const MOST: usize = 9;

/// The rows below which a frame shows the camera's own side, as a dashboard, instead of the glass: a line of straight parts.
///
/// # Example
/// ```
/// use starbreak_optics::environment::Dashboard;
///
/// let dashboard = Dashboard::below(&[0.9, 0.8, 0.9])?;
/// assert_eq!(dashboard.row_px(320.0, (640, 100)), 80.0);
/// assert_eq!(dashboard.row_px(0.0, (640, 100)), 90.0);
/// # Ok::<(), starbreak_optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dashboard {
    rows: [f64; MOST],
    n_rows: usize,
}

impl Dashboard {
    /// Rows as shares of the height from the top, 0 to 1: one of all columns, or up to nine of columns evenly from the left
    /// border to the right; without one there is no dashboard.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] for a row out of range, or more than nine.
    pub fn below(rows: &[f64]) -> Result<Self, OpticsError> {
        #[expect(clippy::cast_precision_loss, reason = "some rows")]
        let n = rows.len() as f64;
        OpticsError::check_ranges(&[("dashboard_rows.len", n, 0.0, 9.0)])?;
        let mut dashboard = Self {
            n_rows: rows.len(),
            ..Self::default()
        };
        for (to, row) in dashboard.rows.iter_mut().zip(rows) {
            OpticsError::check_ranges(&[("dashboard_rows", *row, 0.0, 1.0)])?;
            *to = *row;
        }
        Ok(dashboard)
    }

    /// Whether the frame shows glass all over.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.n_rows == 0
    }

    /// The row below which a column shows it, each as a share of its side of the frame; 1 where it does not.
    #[must_use]
    pub fn row(&self, column: f64) -> f64 {
        match &self.rows[..self.n_rows] {
            [] => 1.0,
            [row] => *row,
            rows => {
                #[expect(clippy::cast_precision_loss, reason = "some rows")]
                let last = (rows.len() - 1) as f64;
                let at = column.clamp(0.0, 1.0) * last;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "some rows"
                )]
                let before = (at as usize).min(rows.len() - 2);
                #[expect(clippy::cast_precision_loss, reason = "some rows")]
                let part = at - before as f64;
                rows[before] + part * (rows[before + 1] - rows[before])
            }
        }
    }

    /// The same in px of a frame of a size.
    #[must_use]
    pub fn row_px(&self, column_px: f64, (width, height): (u32, u32)) -> f64 {
        self.row(column_px / f64::from(width)) * f64::from(height)
    }

    /// The highest and the lowest of its rows, as shares of the height; 1 without one.
    pub(crate) fn ends(&self) -> [f64; 2] {
        let rows = || self.rows[..self.n_rows].iter().copied();
        [rows().reduce(f64::min), rows().reduce(f64::max)].map(|row| row.unwrap_or(1.0))
    }

    /// Share of a cell of so many px of a frame of a size, px, that shows glass, by its column and row.
    pub(crate) fn glass_in(&self, [x, y]: [usize; 2], size: (u32, u32), cell_px: u32) -> f32 {
        let side_px = f64::from(cell_px);
        #[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
        let [x, y] = [x as f64, y as f64];
        let row = self.row_px((x + 0.5) * side_px, size) / side_px;
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let share = (row - y).clamp(0.0, 1.0) as f32;
        share
    }
}
