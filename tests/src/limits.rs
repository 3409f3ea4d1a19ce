//! What the firmware and the C library may take at most: tables of numbers in a file.

use std::collections::BTreeMap;

/// Returns the numbers of a table of a TOML file, whose name may have dots.
///
/// # Errors
/// A file that cannot be read, a table that is not there, and what is no number, in words.
pub fn limits(path: &str, table: &str) -> Result<BTreeMap<String, u64>, String> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|error| format!("{path} cannot be read: {error}"))?;
    let all: toml::Table = text.parse().map_err(|error| format!("{path}: {error}"))?;
    let mut found = Some(&all);
    for name in table.split('.') {
        found = found.and_then(|table| table.get(name)?.as_table());
    }
    let numbers = found
        .ok_or_else(|| format!("{path} has no table {table}"))?
        .iter();
    let limit = |(name, value): (&String, &toml::Value)| {
        let number = value
            .as_integer()
            .and_then(|number| u64::try_from(number).ok());
        let number = number.ok_or_else(|| format!("{path}: {name} is no number"))?;
        Ok((name.clone(), number))
    };
    numbers.map(limit).collect()
}
