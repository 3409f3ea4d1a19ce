//! Tables of text: named fields of several entries.

use std::fmt;

/// A table with a row for each field and a column for each entry; `{:#}` writes it with a
/// row for each entry.
#[derive(Debug)]
#[must_use]
pub struct Table<'e, E> {
    entries: &'e [E],
    fields: Vec<Vec<String>>,
}

impl<'e, E> Table<'e, E> {
    /// Returns a table of these entries without fields.
    pub fn new(entries: &'e [E]) -> Self {
        Self {
            entries,
            fields: Vec::new(),
        }
    }

    /// Adds a field of texts.
    pub fn text(mut self, name: impl Into<String>, cell: impl Fn(&E) -> String) -> Self {
        let cells = std::iter::once(name.into()).chain(self.entries.iter().map(cell));
        self.fields.push(cells.collect());
        self
    }

    /// Adds a field of whole numbers.
    pub fn count(self, name: impl Into<String>, cell: impl Fn(&E) -> u64) -> Self {
        self.text(name, |entry| cell(entry).to_string())
    }

    /// Adds a field of numbers, rounded to `digits` after the point; `-` for no finite number.
    pub fn number<N: Into<Option<f64>>>(
        self,
        name: impl Into<String>,
        digits: usize,
        cell: impl Fn(&E) -> N,
    ) -> Self {
        self.text(name, |entry| match cell(entry).into() {
            Some(number) if number.is_finite() => format!("{number:.digits$}"),
            _ => "-".to_owned(),
        })
    }
}

impl<E> fmt::Display for Table<'_, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (fields, places) = (self.fields.len(), self.entries.len() + 1);
        let by_entry = f.alternate();
        let (rows, columns) = if by_entry {
            (places, fields)
        } else {
            (fields, places)
        };
        let cell = |row: usize, column: usize| {
            let (field, place) = if by_entry {
                (column, row)
            } else {
                (row, column)
            };
            &self.fields[field][place]
        };
        let width = |column| (0..rows).map(|row| cell(row, column).chars().count()).max();
        let widths: Vec<usize> = (0..columns).map(|one| width(one).unwrap_or(0)).collect();
        for row in 0..rows {
            let cells = widths
                .iter()
                .enumerate()
                .map(|(column, &width)| match column {
                    0 => format!("{:<width$}", cell(row, column)),
                    _ => format!("{:>width$}", cell(row, column)),
                });
            let line = cells.collect::<Vec<_>>().join("  ");
            let end = if row + 1 < rows { "\n" } else { "" };
            write!(f, "{}{end}", line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_rows_or_columns() {
        let table = Table::new(&[1.0, 20.5])
            .text("ΔE", |one| format!("#{one}"))
            .number("half", 2, |one| (*one > 1.0).then_some(one / 2.0))
            .count("whole", |one| *one as u64);
        let rows = "ΔE     #1  #20.5\nhalf    -  10.25\nwhole   1     20";
        assert_eq!(table.to_string(), rows);
        let columns = "ΔE      half  whole\n#1         -      1\n#20.5  10.25     20";
        assert_eq!(format!("{table:#}"), columns);
    }
}
