//! TOML descriptions, and faults that point at the line they are on.

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceCode, SourceSpan};
use serde::de::DeserializeOwned;
use std::fmt;
use std::ops::Range;

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

    /// What is wrong.
    pub fn fault(&self) -> &F {
        &self.fault
    }

    /// Where: the line, counted from 1; `None` where the fault is of the
    /// whole file.
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
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.fault.code()
    }

    fn severity(&self) -> Option<Severity> {
        self.fault.severity()
    }

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

/// A description's text and what messages call it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    /// The file's name, for messages.
    pub(crate) name: &'a str,
    /// All of it.
    pub(crate) text: &'a str,
}

impl Source<'_> {
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

/// What to suggest where `given` is none of `names`: the one that is most
/// like it, or all where none is.
pub(crate) fn suggestion<'a>(
    given: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let names: Vec<&str> = names.into_iter().collect();
    let nearest = names
        .iter()
        .map(|name| (edit_distance(given, name), *name))
        .min()?;
    Some(match nearest {
        (distance, name) if distance * 2 <= name.chars().count().max(2) => {
            format!("did you mean \"{name}\"?")
        }
        _ => format!("use one of: {}", names.join(", ")),
    })
}

/// Levenshtein's distance, letters of either case being the same.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distance_counts_single_letter_edits() {
        for (a, b, expected) in [
            ("", "", 0),
            ("", "abc", 3),
            ("abc", "", 3),
            ("kitten", "sitting", 3),
            ("Chrome", "chrome", 0),
            ("flaw", "lawn", 2),
        ] {
            assert_eq!(edit_distance(a, b), expected, "{a} to {b}");
        }
    }

    #[test]
    fn suggests_the_nearest_or_all() {
        let names = ["chrome", "clay", "glass"];
        assert_eq!(
            suggestion("crome", names).as_deref(),
            Some("did you mean \"chrome\"?")
        );
        assert_eq!(
            suggestion("velvety", names).as_deref(),
            Some("use one of: chrome, clay, glass")
        );
        assert_eq!(suggestion("crome", []), None);
    }
}
