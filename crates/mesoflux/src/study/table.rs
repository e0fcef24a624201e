//! Tables that a run leaves beside its results, read back by the names of their columns.

/// A number with its standard error; `None` where the run couldn't tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// The number.
    pub value: Option<f64>,
    /// Its standard error; zero if it is exact.
    pub error: Option<f64>,
}

/// The columns of one row by name.
pub type Cells = Vec<(String, Cell)>;

/// The column that holds the error of the one before it.
const ERROR: &str = "standard_error";

/// The rows of a CSV text with a header `name [unit],…`. A column `standard_error` belongs to the one before it.
pub fn rows(csv: &str) -> Vec<Cells> {
    let mut lines = csv.lines();
    let header = lines.next().unwrap_or_default();
    let names: Vec<&str> = header.split(',').map(|name| name.split(" [").next().unwrap_or(name).trim()).collect();
    let row = |line: &str| {
        let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        let numbers: Vec<Option<f64>> = line.split(',').map(number).collect();
        let at = |k: usize| numbers.get(k).copied().flatten();
        let cell = |(k, name): (usize, &&str)| {
            let error = if names.get(k + 1) == Some(&ERROR) { at(k + 1) } else { Some(0.0) };
            ((*name).to_owned(), Cell { value: at(k), error })
        };
        names.iter().enumerate().filter(|(_, name)| **name != ERROR).map(cell).collect()
    };
    lines.filter(|line| !line.trim().is_empty()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_belongs_to_the_column_before_it() {
        let text = "flux [v],forcing [f],standard_error [f],variance [f2],standard_error [f2]\n0.1,2,0.3,4,0.5\n0.2,3,x,,0.5\n";
        let rows = rows(text);
        let cell = |row: usize, name: &str| rows[row].iter().find(|(own, _)| own == name).unwrap().1;
        assert_eq!(cell(0, "flux"), Cell { value: Some(0.1), error: Some(0.0) });
        assert_eq!(cell(0, "forcing"), Cell { value: Some(2.0), error: Some(0.3) });
        assert_eq!(cell(0, "variance"), Cell { value: Some(4.0), error: Some(0.5) });
        assert_eq!(cell(1, "forcing"), Cell { value: Some(3.0), error: None });
        assert_eq!(cell(1, "variance"), Cell { value: None, error: Some(0.5) });
        assert_eq!(rows.len(), 2);
    }
}
