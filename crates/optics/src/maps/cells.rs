//! Cells of a row, of which few are touched.

/// What a grid cell of one row holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell<const L: usize> {
    pub(super) lanes: [f32; L],
    /// Kernel of what covers most of it, and how much that is.
    pub(super) kernel: u32,
    most: f32,
    is_touched: bool,
}

/// A row of cells in the making.
pub(super) struct Row<const L: usize> {
    cells: Vec<Cell<L>>,
    touched: Vec<usize>,
}

impl<const L: usize> Row<L> {
    pub(super) fn new(n: usize) -> Self {
        let cell = Cell {
            lanes: [0.0; L],
            kernel: 0,
            most: 0.0,
            is_touched: false,
        };
        Self {
            cells: vec![cell; n],
            touched: Vec::new(),
        }
    }

    /// A cell that will be added to.
    #[inline(always)]
    pub(super) fn cell(&mut self, column: usize, kernel: u32, covers: f32) -> &mut Cell<L> {
        let cell = &mut self.cells[column];
        if !cell.is_touched {
            cell.is_touched = true;
            self.touched.push(column);
            cell.kernel = kernel;
            cell.most = covers;
        } else if covers > cell.most {
            cell.kernel = kernel;
            cell.most = covers;
        }
        cell
    }

    /// Takes the next touched cells that lie side by side and have one kernel, from the `k`-th on:
    /// column of the first and kernel; their lanes go into `lanes`, and the cells are then empty.
    #[inline(always)]
    pub(super) fn take_run(&mut self, k: usize, lanes: &mut Vec<[f32; L]>) -> Option<(usize, u32)> {
        lanes.clear();
        let first = *self.touched.get(k)?;
        let kernel = self.cells[first].kernel;
        for (column, touched) in (first..).zip(&self.touched[k..]) {
            let cell = &mut self.cells[column.min(*touched)];
            if column != *touched || cell.kernel != kernel {
                break;
            }
            cell.is_touched = false;
            lanes.push(std::mem::replace(&mut cell.lanes, [0.0; L]));
        }
        Some((first, kernel))
    }

    /// Forgets which cells were touched; all have been taken.
    pub(super) fn clear(&mut self) {
        self.touched.clear();
    }
}
