//! Cells of a row, of which few are touched.

/// What a grid cell holds of the facets of one row.
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

    /// How many cells are touched.
    pub(super) fn n_touched(&self) -> usize {
        self.touched.len()
    }

    /// Column, lanes and kernel of the k-th touched cell, which is then empty.
    #[inline(always)]
    pub(super) fn take(&mut self, k: usize) -> (usize, [f32; L], u32) {
        let column = self.touched[k];
        let cell = &mut self.cells[column];
        cell.is_touched = false;
        (
            column,
            std::mem::replace(&mut cell.lanes, [0.0; L]),
            cell.kernel,
        )
    }

    /// Forgets which cells were touched; all have been taken.
    pub(super) fn clear(&mut self) {
        self.touched.clear();
    }
}
