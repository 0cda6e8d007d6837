//! The assignment of rows to columns of the least total cost, for costs that are not integers.
//!
//! The shortest augmenting paths of Crouse (2016), "On implementing 2D rectangular assignment algorithms". The order of
//! steps is that of SciPy's `linear_sum_assignment`, so that it chooses the same one of several equally good assignments.

/// The pairs (row, column) of the least total cost, by row. Each row of the shorter side is in one pair. `costs` holds
/// `rows` rows of `columns` finite numbers.
pub(super) fn cheapest(rows: usize, columns: usize, costs: &[f64]) -> Vec<(usize, usize)> {
    if rows > columns {
        let transposed: Vec<f64> =
            (0..columns).flat_map(|column| (0..rows).map(move |row| costs[row * columns + column])).collect();
        let mut pairs: Vec<_> =
            cheapest(columns, rows, &transposed).into_iter().map(|(column, row)| (row, column)).collect();
        pairs.sort_unstable();
        return pairs;
    }
    let mut search = Search {
        costs,
        columns,
        row_prices: vec![0.0; rows],
        column_prices: vec![0.0; columns],
        column_of: vec![None; rows],
        row_of: vec![None; columns],
    };
    (0..rows).for_each(|row| search.add(row));
    search.column_of.iter().enumerate().filter_map(|(row, column)| Some((row, (*column)?))).collect()
}

/// The assignment of the rows so far, and the prices that prove that it is the cheapest.
struct Search<'a> {
    costs: &'a [f64],
    columns: usize,
    row_prices: Vec<f64>,
    column_prices: Vec<f64>,
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
}

impl Search<'_> {
    /// Assigns a further row: along the shortest path from it to a free column, each row takes the column of the next.
    fn add(&mut self, row: usize) {
        let mut lengths = vec![f64::INFINITY; self.columns];
        let mut comes_from = vec![row; self.columns];
        // In reverse, as the last one of equal columns is taken first otherwise.
        let mut open: Vec<usize> = (0..self.columns).rev().collect();
        let mut closed = Vec::new();
        let (mut length, mut at) = (0.0, row);
        let free = loop {
            let mut nearest: Option<(usize, f64)> = None;
            for (place, &column) in open.iter().enumerate() {
                let cost = self.costs[at * self.columns + column];
                let through = length + cost - self.row_prices[at] - self.column_prices[column];
                if through < lengths[column] {
                    comes_from[column] = at;
                    lengths[column] = through;
                }
                let is_free = self.row_of[column].is_none();
                if nearest
                    .is_none_or(|(_, least)| lengths[column] < least || lengths[column] == least && is_free)
                {
                    nearest = Some((place, lengths[column]));
                }
            }
            // There are no more rows than columns, so a free column is open.
            let Some((place, least)) = nearest else { return };
            length = least;
            let column = open.swap_remove(place);
            closed.push(column);
            match self.row_of[column] {
                Some(next) => at = next,
                None => break column,
            }
        };
        self.row_prices[row] += length;
        for &column in &closed {
            if let Some(reached) = self.row_of[column] {
                self.row_prices[reached] += length - lengths[column];
            }
            self.column_prices[column] -= length - lengths[column];
        }
        let mut column = free;
        loop {
            let taker = comes_from[column];
            self.row_of[column] = Some(taker);
            let Some(left) = self.column_of[taker].replace(column) else { break };
            column = left;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn total(columns: usize, costs: &[f64], pairs: &[(usize, usize)]) -> f64 {
        pairs.iter().map(|(row, column)| costs[row * columns + column]).sum()
    }

    /// The least total cost of all assignments of the rows from `row` on, none fewer than columns.
    fn least(row: usize, rows: usize, columns: usize, costs: &[f64], taken: u32) -> f64 {
        if row == rows {
            return 0.0;
        }
        (0..columns)
            .filter(|column| taken & 1 << column == 0)
            .map(|column| {
                costs[row * columns + column] + least(row + 1, rows, columns, costs, taken | 1 << column)
            })
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn the_total_is_that_of_the_best_of_all_assignments(
            (rows, columns, costs) in (1_usize..6, 0_usize..3).prop_flat_map(|(rows, more)| {
                let columns = rows + more;
                // Integers with many ties.
                (Just(rows), Just(columns), prop::collection::vec((-4_i32..5).prop_map(f64::from), rows * columns))
            }),
        ) {
            let expected = least(0, rows, columns, &costs, 0);
            let pairs = cheapest(rows, columns, &costs);
            prop_assert_eq!(pairs.len(), rows);
            prop_assert_eq!(total(columns, &costs, &pairs), expected);
            let mut taken: Vec<_> = pairs.iter().map(|(_, column)| column).collect();
            taken.sort_unstable();
            taken.dedup();
            prop_assert_eq!(taken.len(), rows);

            let transposed: Vec<f64> =
                (0..columns).flat_map(|column| (0..rows).map(|row| costs[row * columns + column]).collect::<Vec<_>>()).collect();
            let exchanged = cheapest(columns, rows, &transposed);
            prop_assert!(exchanged.is_sorted());
            prop_assert_eq!(total(rows, &transposed, &exchanged), expected);
        }
    }

    #[test]
    fn of_equal_assignments_it_chooses_that_of_scipy() {
        let of = |rows, columns, costs: &[i32]| {
            cheapest(rows, columns, &costs.iter().map(|&cost| f64::from(cost)).collect::<Vec<_>>())
        };
        assert_eq!(of(3, 3, &[0; 9]), [(0, 0), (1, 1), (2, 2)]);
        let costs = [-2, -2, 0, -2, -1, -1, -1, 0, -2, 0, 0, -1, -1, -1, 0, 0];
        assert_eq!(of(4, 4, &costs), [(0, 3), (1, 2), (2, 0), (3, 1)]);
        let costs = [0, 0, 0, -2, 0, -1, -2, 0, 0, -1, 0, -2, 0, -2, -2];
        assert_eq!(of(3, 5, &costs), [(0, 3), (1, 1), (2, 4)]);
        let costs = [-2, 0, -1, -1, -1, -1, -2, -1, 0, -2, -1, -2, 0, -1, -2];
        assert_eq!(of(5, 3, &costs), [(0, 0), (1, 1), (3, 2)]);
        assert_eq!(cheapest(0, 3, &[]), []);
        assert_eq!(cheapest(3, 0, &[]), []);
    }
}
