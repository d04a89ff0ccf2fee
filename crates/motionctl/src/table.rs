//! The look that all tables of the tool share.

use comfy_table::{CellAlignment, Table};

/// Puts the numbers of a table to the right; its last column holds words and stays to the left.
pub(crate) fn align_numbers(table: &mut Table) {
    let last = table.column_count().saturating_sub(1);
    for column in table.column_iter_mut().take(last) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}
