//! Tables in aligned Markdown, readable in a terminal as they are.

/// A table with a header line; every row has as many cells as the header.
pub fn markdown(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |text: &str| text.chars().count();
    let mut widths: Vec<usize> = header.iter().map(|title| width(title)).collect();
    for row in rows {
        for (column, cell) in row.iter().enumerate() {
            widths[column] = widths[column].max(width(cell));
        }
    }
    let line = |cells: Vec<&str>| {
        let padded: Vec<String> = cells
            .iter()
            .zip(&widths)
            .map(|(cell, &wide)| format!("{cell}{}", " ".repeat(wide - width(cell))))
            .collect();
        format!("| {} |\n", padded.join(" | "))
    };
    let rules: Vec<String> = widths.iter().map(|&wide| "-".repeat(wide)).collect();
    let mut text = line(header.to_vec());
    text.push_str(&line(rules.iter().map(String::as_str).collect()));
    for row in rows {
        text.push_str(&line(row.iter().map(String::as_str).collect()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let table = markdown(&["step", "s"], &[vec!["Green–Kubo".into(), "1.0".into()]]);
        assert_eq!(table, "| step       | s   |\n| ---------- | --- |\n| Green–Kubo | 1.0 |\n");
    }
}
