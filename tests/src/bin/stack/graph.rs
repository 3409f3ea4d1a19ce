//! What a function takes together with all that it calls.

use crate::code::{Program, Wrong};
use crate::frame::{Callee, Frame, frame};
use std::collections::{BTreeMap, BTreeSet};

/// A function, and the deepest way down from it.
#[derive(Debug, Clone)]
pub(crate) struct Deepest {
    /// Bytes of all frames of it.
    pub(crate) bytes: u32,
    /// The functions on it with their own frames, from the top.
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

    /// The deepest way down from a function.
    ///
    /// # Errors
    /// Recursion, and what cannot be followed.
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

    /// Where a call may lead. A pointer that was loaded at an offset leads to no
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

    /// How many functions pointers may lead to.
    pub(crate) fn pointed_at(&self) -> usize {
        let methods = self.program.methods.values().flatten();
        let all: BTreeSet<_> = self.program.taken.iter().chain(methods).collect();
        all.len()
    }

    /// Functions that have been looked at, by their own frames.
    pub(crate) fn frames(&self) -> Result<Vec<(u32, Frame)>, Wrong> {
        self.done
            .keys()
            .map(|&at| Ok((at, frame(self.program, at)?)))
            .collect()
    }
}
