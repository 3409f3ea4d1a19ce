//! TOML descriptions, and faults that point at the line they are on.

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fmt, io};
use thiserror::Error;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A fault in a text file and the place it is at.
///
/// Prints as the fault itself, after the file's name where the fault is of the
/// whole file; as a [`Diagnostic`] it also shows the line.
#[derive(Debug)]
pub struct Located<F> {
    fault: Box<F>,
    source_code: Box<NamedSource<String>>,
    span: Option<SourceSpan>,
}

impl<F> Located<F> {
    /// Returns a fault at `span`, a range of bytes of the source; `None` where the
    /// fault is of the whole file.
    pub(crate) fn new(fault: F, source: &Source<'_>, span: Option<Range<usize>>) -> Self {
        Self {
            fault: Box::new(fault),
            source_code: Box::new(NamedSource::new(source.name, source.text.to_owned())),
            span: span.map(SourceSpan::from),
        }
    }

    /// Where: the line, counted from 1; `None` where the fault is of the whole file.
    pub fn line(&self) -> Option<usize> {
        let text = self.source_code.inner().as_bytes();
        let start = self.span?.offset().min(text.len());
        Some(text[..start].split(|&byte| byte == b'\n').count())
    }
}

impl<F: fmt::Display> fmt::Display for Located<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.span.is_none() {
            write!(f, "{}: ", self.source_code.name())?;
        }
        self.fault.fmt(f)
    }
}

impl<F: std::error::Error> std::error::Error for Located<F> {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.fault.source()
    }
}

impl<F: Diagnostic> Diagnostic for Located<F> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.fault.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        // Without a place there is no line worth showing.
        self.span?;
        Some(&*self.source_code)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = LabeledSpan::new_with_span(Some("here".into()), self.span?);
        Some(Box::new(std::iter::once(label)))
    }
}

/// Why a file of a scene, walls or a projector could not be used.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages are the docs")]
pub enum FileError<F: Diagnostic + 'static> {
    #[error("cannot read {what} in {}", path.display())]
    #[diagnostic(help("{help}"))]
    Read {
        what: &'static str,
        help: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] Located<F>),
}

pub(crate) fn read_description<F: Diagnostic>(
    path: &Path,
    what: &'static str,
    help: &'static str,
) -> Result<String, FileError<F>> {
    super::read_text(path).map_err(|source| FileError::Read {
        what,
        help,
        path: path.to_owned(),
        source,
    })
}

/// A description's text and what messages call it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Returns the folder that paths in the text start at.
    pub(crate) fn folder(&self) -> &Path {
        Path::new(self.name).parent().unwrap_or(Path::new(""))
    }

    /// Returns where the value of a key is: in the top table of the text, or in an entry of a list
    /// of tables, by the list's name and the entry's number from 0.
    pub(crate) fn span_of(&self, list: Option<(&str, usize)>, key: &str) -> Option<Range<usize>> {
        let text = DeTable::parse(self.text).ok()?;
        let table = match list {
            None => text.get_ref(),
            Some((name, number)) => {
                let list = text.get_ref().get(name)?.get_ref();
                list.get(number)?.get_ref().as_table()?
            }
        };
        Some(table.get(key)?.span())
    }

    /// Reads TOML.
    ///
    /// # Errors
    /// Text that is not TOML, a key that `T` does not know, a value of the wrong type or a missing
    /// key, as `fault` makes it of a message and its help. `syntax` describes keys; it is the help
    /// where it has all keys that could be at the place.
    pub(crate) fn parse<T: DeserializeOwned, F>(
        &self,
        syntax: &str,
        fault: impl FnOnce(String, String) -> F,
    ) -> Result<T, Located<F>> {
        toml::from_str(self.text).map_err(|error| {
            let (message, help) = self.in_plain_words(&error, syntax);
            Located::new(fault(message, help), self, error.span())
        })
    }

    /// Returns the message and the help for an error of `toml` or `serde`, whose messages are
    /// recognised by their first words.
    fn in_plain_words(&self, error: &toml::de::Error, syntax: &str) -> (String, String) {
        let message = error.message();
        let Ok(root) = DeTable::parse(self.text) else {
            let help = "a line is KEY = VALUE, with text in \"quotes\" and lists in [brackets], or \
                        [NAME] or [[NAME]] before the keys of a table; a key stands once in a table";
            return (
                format!("this is not valid TOML: {message}"),
                help.to_owned(),
            );
        };
        let mut names = message.split('`').skip(1).step_by(2);
        let mut name = || names.next().unwrap_or_default();
        if message.starts_with("unknown field") {
            let (given, known) = (name(), names.collect::<Vec<_>>());
            let fits = known.iter().all(|key| syntax.contains(key));
            let help = suggestion(given, known);
            let help = help.filter(|help| !fits || help.starts_with("did you mean"));
            let help = help.unwrap_or_else(|| syntax.to_owned());
            return (format!("unknown key `{given}`"), help);
        }
        if message.starts_with("missing field") {
            let key = name();
            let help = if syntax.contains(key) {
                syntax.to_owned()
            } else {
                format!("add `{key} = ` and its value to this table")
            };
            return (format!("the key `{key}` is missing"), help);
        }
        let values = message.strip_prefix("invalid ");
        let Some((found, expected)) = values.and_then(|text| text.rsplit_once(", expected "))
        else {
            return (message.to_owned(), syntax.to_owned());
        };
        let span = error.span().unwrap_or_default();
        let keys = root.get_ref().iter();
        let keys = keys.filter_map(|(key, value)| key_of(value, key.get_ref(), &span));
        let (length, key) = keys.min().unwrap_or((span.len(), "KEY"));
        let is_within = length > span.len();
        let is_nested = self.text[span].matches('[').count() > 1;
        let (wanted, example) = wanted(expected, is_nested);
        let is_table = found.ends_with(": map");
        let help = if is_table && expected == "a sequence" {
            format!("write [[{key}]] in place of [{key}]")
        } else if is_within {
            format!("for example, {example}")
        } else {
            format!("for example, {key} = {example}")
        };
        let found = found
            .find(['"', '`'])
            .map(|at| found[at..].trim_matches('`'));
        let found = found.or(is_table.then_some("a table"));
        let but = found.map_or(String::new(), |found| format!(", not {found}"));
        let owner = if is_within { "a value of " } else { "" };
        (format!("{owner}`{key}` must be {wanted}{but}"), help)
    }
}

/// Returns the innermost key whose value has the given place in the text, and the value's length.
fn key_of<'t>(
    value: &'t Spanned<DeValue<'_>>,
    key: &'t str,
    at: &Range<usize>,
) -> Option<(usize, &'t str)> {
    let span = value.span();
    let is_here = span.start <= at.start && at.end <= span.end;
    let own = is_here.then_some((span.len(), key));
    let within = match value.get_ref() {
        DeValue::Array(values) => {
            let keys = values.iter().filter_map(|value| key_of(value, key, at));
            // A value of the list has no key of its own.
            keys.filter(|(_, found)| !std::ptr::eq(*found, key)).min()
        }
        DeValue::Table(values) => {
            let keys = values.iter();
            let keys = keys.filter_map(|(key, value)| key_of(value, key.get_ref(), at));
            keys.min()
        }
        _ => None,
    };
    within.into_iter().chain(own).min()
}

/// Returns what a value must be, in words for what `serde` expects, and an example. `is_nested`
/// says whether the value is a list of lists.
fn wanted(expected: &str, is_nested: bool) -> (&str, &'static str) {
    match expected {
        "f32" | "f64" => ("a number", "1.5"),
        "u8" | "u16" | "u32" | "u64" => ("a whole number, 0 or more", "2"),
        "a boolean" => ("true or false", "true"),
        "a string" => ("text in quotes", "\"text\""),
        "a sequence" => ("a list", "[1, 2]"),
        "a map" => ("a table", "{ KEY = VALUE }"),
        "an array of length 2" if is_nested => ("two lists", "[[1, 1, 1], [0, 0, 0]]"),
        "an array of length 2" => ("two numbers", "[1, 2]"),
        "an array of length 3" => ("three numbers", "[1, 0, 2.5]"),
        "an array of length 4" => ("four numbers", "[0, 0, 0, 1]"),
        _ if expected.starts_with("struct") => ("a table", "{ KEY = VALUE }"),
        _ => (expected, "2"),
    }
}

/// An unknown name of a built-in thing.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no built-in {kind} \"{given}\": use {known}")]
pub struct UnknownName {
    /// The kind of thing.
    pub kind: &'static str,
    /// The name.
    pub given: String,
    /// The names there are, in words.
    pub known: &'static str,
}

/// Suggests the name most like `given`, or all names if none is like it.
pub(crate) fn suggestion<'a>(
    given: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let names: Vec<&str> = names.into_iter().collect();
    let given = given.to_lowercase();
    let distance = |name: &str| strsim::levenshtein(&given, &name.to_lowercase());
    let nearest = names.iter().map(|name| (distance(name), *name)).min()?;
    Some(match nearest {
        (distance, name) if distance * 2 <= name.chars().count().max(2) => {
            format!("did you mean \"{name}\"?")
        }
        _ => format!("use one of: {}", names.join(", ")),
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns the number of the first line with this part of a text.
    pub(crate) fn line_of(text: &str, part: &str) -> usize {
        1 + text
            .split(part)
            .next()
            .unwrap_or(text)
            .matches('\n')
            .count()
    }

    /// Checks a table of one fault a line: what is replaced in a text, by what, a part of the
    /// message, and the line that the fault points at, where it is not the replaced one: a part of
    /// it, `*` for any but the first, `-` for none.
    pub(crate) fn check_faults<T, F: Diagnostic>(
        text: &str,
        faults: &str,
        read: impl Fn(&str) -> Result<T, Located<F>>,
    ) {
        for row in faults.trim().lines() {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let [from, to, says, ..] = cells[..] else {
                panic!("{row}");
            };
            assert!(text.contains(from), "{row}");
            let read = read(&text.replacen(from, &to.replace("\\n", "\n"), 1));
            let error = read.err().expect(row);
            assert!(error.to_string().contains(says), "{row}: {error}");
            let medium = error.to_string().starts_with("the medium \"");
            assert!(medium || error.help().is_some(), "{row}");
            match *cells.get(3).unwrap_or(&from) {
                "-" => assert_eq!(error.line(), None, "{row}"),
                "*" => assert!(error.line().is_some_and(|line| line > 1), "{row}"),
                place => assert_eq!(error.line(), Some(line_of(text, place)), "{row}: {error}"),
            }
        }
    }
}
