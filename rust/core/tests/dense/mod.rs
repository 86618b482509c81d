//! Linear equations, plainly.

/// Gaussian elimination with pivots; the last column is the right side.
#[expect(
    clippy::needless_range_loop,
    reason = "matrices are read by their places"
)]
pub(crate) fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let count = rows.len();
    for k in 0..count {
        let pivot = (k..count).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()));
        rows.swap(k, pivot.unwrap());
        for below in k + 1..count {
            let share = rows[below][k] / rows[k][k];
            for j in k..=count {
                rows[below][j] -= share * rows[k][j];
            }
        }
    }
    let mut answer = vec![0.0; count];
    for k in (0..count).rev() {
        let rest: f64 = (k + 1..count).map(|j| rows[k][j] * answer[j]).sum();
        answer[k] = (rows[k][count] - rest) / rows[k][k];
    }
    answer
}
