//! What a function takes together with all that it calls.

use crate::code::{Program, Wrong};
use crate::frame::{Callee, frame};
use std::collections::{BTreeMap, BTreeSet};

/// The deepest way down from a function.
#[derive(Debug, Clone)]
pub(crate) struct Deepest {
    /// Bytes of all its frames.
    pub(crate) bytes: u32,
    /// Its functions and their frames' bytes, from the top.
    pub(crate) way: Vec<(u32, u32)>,
}

/// Calls of a program, found as they are asked for.
pub(crate) struct Graph<'p> {
    program: &'p Program,
    done: BTreeMap<u32, Deepest>,
}

impl<'p> Graph<'p> {
    pub(crate) fn new(program: &'p Program) -> Self {
        Self {
            program,
            done: BTreeMap::new(),
        }
    }

    /// Returns the deepest way down from a function; recursion is an error.
    pub(crate) fn deepest(&mut self, from: u32) -> Result<Deepest, Wrong> {
        self.descend(from, &mut Vec::new())
    }

    fn descend(&mut self, at: u32, above: &mut Vec<u32>) -> Result<Deepest, Wrong> {
        if let Some(known) = self.done.get(&at) {
            return Ok(known.clone());
        }
        if let Some(place) = above.iter().position(|&function| function == at) {
            let circle: Vec<_> = above[place..].iter().chain([&at]).collect();
            let names: Vec<_> = circle.iter().map(|&&at| self.program.name(at)).collect();
            return Err(format!("recursion: {}", names.join(" → ")));
        }
        let own = frame(self.program, at)?;
        above.push(at);
        let mut deepest = Deepest {
            bytes: own.bytes,
            way: vec![(at, own.bytes)],
        };
        for (&callee, &bytes) in &own.calls {
            for to in self.targets(callee) {
                let below = self.descend(to, above)?;
                if bytes + below.bytes > deepest.bytes {
                    deepest.bytes = bytes + below.bytes;
                    deepest.way = vec![(at, bytes)];
                    deepest.way.extend(below.way);
                }
            }
        }
        above.pop();
        self.done.insert(at, deepest.clone());
        Ok(deepest)
    }

    /// Returns where a call may lead. A pointer that was loaded at an offset leads to no
    /// method that stands at another.
    fn targets(&self, callee: Callee) -> BTreeSet<u32> {
        let Program { taken, methods, .. } = self.program;
        match callee {
            Callee::Function(to) => BTreeSet::from([to]),
            Callee::Pointer(offset) => {
                let at = |known: &i32| offset.is_none_or(|offset| offset == *known);
                let methods = methods.iter().filter(|(known, _)| at(known));
                let methods = methods.flat_map(|(_, methods)| methods);
                taken.iter().chain(methods).copied().collect()
            }
        }
    }

    /// Returns what has been looked at, in a sentence.
    pub(crate) fn summary(&self) -> Result<String, Wrong> {
        let frames = self.done.keys().map(|&at| frame(self.program, at));
        let frames = frames.collect::<Result<Vec<_>, Wrong>>()?;
        let largest = frames.iter().map(|frame| frame.bytes).max();
        Ok(format!(
            "{} functions, none of them recursive; the largest frame has {} bytes; pointers lead \
             to {}",
            frames.len(),
            largest.unwrap_or(0),
            self.targets(Callee::Pointer(None)).len(),
        ))
    }
}
