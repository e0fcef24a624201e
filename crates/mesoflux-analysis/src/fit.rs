//! Small symmetric positive-definite systems of equations, by Cholesky's factorization.

/// The lower triangle L of A = L Lᵀ, stored row by row.
pub(crate) struct Cholesky {
    rows: Vec<Vec<f64>>,
}

impl Cholesky {
    /// Factorizes the symmetric matrix given by its rows (only the lower triangle is read).
    ///
    /// `None` unless the matrix is positive definite to working precision: a pivot below 1e-13 of its diagonal entry
    /// means that the unknowns aren't determined by the data.
    pub(crate) fn new(matrix: &[Vec<f64>]) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(matrix.len());
        for (i, source) in matrix.iter().enumerate() {
            let mut row: Vec<f64> = Vec::with_capacity(i + 1);
            for j in 0..i {
                let inner: f64 = row.iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
                row.push((source[j] - inner) / rows[j][j]);
            }
            let pivot = source[i] - row.iter().map(|a| a * a).sum::<f64>();
            let definite = pivot.is_finite() && pivot > 1e-13 * source[i].abs();
            if !definite {
                return None;
            }
            row.push(pivot.sqrt());
            rows.push(row);
        }
        Some(Self { rows })
    }

    /// The solution x of A x = b.
    pub(crate) fn solve(&self, right_side: &[f64]) -> Vec<f64> {
        let mut x = right_side.to_vec();
        for i in 0..x.len() {
            let inner: f64 = self.rows[i][..i].iter().zip(&x).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - inner) / self.rows[i][i];
        }
        for i in (0..x.len()).rev() {
            let inner: f64 = (i + 1..x.len()).map(|j| self.rows[j][i] * x[j]).sum();
            x[i] = (x[i] - inner) / self.rows[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_system_done_by_hand() {
        // [4 2; 2 3] x = [8 7] has x = [5/4 3/2].
        let factor = Cholesky::new(&[vec![4.0, 2.0], vec![2.0, 3.0]]).unwrap();
        let x = factor.solve(&[8.0, 7.0]);
        assert!((x[0] - 1.25).abs() < 1e-14 && (x[1] - 1.5).abs() < 1e-14);
    }

    #[test]
    fn refuses_a_singular_or_indefinite_matrix() {
        assert!(Cholesky::new(&[vec![1.0, 1.0], vec![1.0, 1.0]]).is_none());
        assert!(Cholesky::new(&[vec![1.0, 2.0], vec![2.0, 1.0]]).is_none());
        assert!(Cholesky::new(&[vec![f64::NAN]]).is_none());
    }
}
