//! TOML descriptions, and faults that point at the line they are on.

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fmt, io};
use thiserror::Error;
use toml::de::DeTable;

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
    /// A fault at `span`, a range of bytes of the source; `None` where the
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
    /// Where the value of a key is: in the top table of the text, or in an entry of a list of
    /// tables, by the list's name and the entry's number from 0.
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
    /// Text that is not TOML, a key that `T` does not know, a value of the
    /// wrong type or a missing key, as `fault` makes it of the message.
    pub(crate) fn parse<T: DeserializeOwned, F>(
        &self,
        fault: impl FnOnce(String) -> F,
    ) -> Result<T, Located<F>> {
        toml::from_str(self.text)
            .map_err(|error| Located::new(fault(error.message().to_owned()), self, error.span()))
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

    /// The number of the first line with this part of a text.
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
