//! The most stack that a linked program can take, from its machine code: the
//! frame of each function, and the deepest way down through its calls.
//!
//!     cargo run -p shisen-tests --bin stack -- image LIMITS TABLE ELF [PAINTED]
//!     cargo run -p shisen-tests --bin stack -- library LIMITS TABLE ELF NAME...
//!
//! An `image` starts where its vector table says; on top of that comes one of its
//! interrupts. Of a `library` the functions of those names count.
//! TABLE is one of the file LIMITS: bytes at most for each of them. PAINTED are
//! the bytes that a run has been seen to take, which cannot be more.
//!
//! - Frames come from the instructions that move the stack pointer, followed along
//!   all ways through a function. One that is not understood is a failure.
//! - A call through a pointer may lead to each function whose address is anywhere
//!   in the program: in its data, between its functions, or in the instructions
//!   that put one together. Only the vector table does not count, which the
//!   hardware reads, and methods of trait objects count where they can be meant:
//!   what looks like a method table (what drops it, size, alignment, methods) is
//!   read at fixed offsets, so a pointer that was loaded at an offset leads to the
//!   methods at that one. A pointer of which that is not known leads to all.
//! - Recursion is a failure, and so is a call of what is no function.
//! - Interrupts have one priority, so that none interrupts another; each takes the
//!   registers that the hardware saves, those for numbers with a point included.
//!   A fault ends the program and is not counted.

mod code;
mod frame;
mod graph;

use code::{Program, Wrong};
use graph::{Deepest, Graph};
use shisen_tests::limits::limits;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// What a Cortex-M7 saves on the stack for an interrupt: 8 registers, 16 of
/// single precision, their state, a gap, and up to 4 bytes to align them.
const SAVED: u32 = 8 * 4 + 18 * 4 + 4;

/// How the names of the board's faults begin, which nothing comes back from.
const FAULTS: [&str; 2] = ["HardFault", "DefaultHandler"];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let found = match arguments.as_slice() {
        ["image", limits, table, elf, painted @ ..] if painted.len() < 2 => {
            image(limits, table, elf, painted.first().copied())
        }
        ["library", limits, table, elf, names @ ..] if !names.is_empty() => {
            library(limits, table, elf, names)
        }
        _ => {
            eprintln!(
                "give: image LIMITS TABLE ELF [PAINTED], or: library LIMITS TABLE ELF NAME..."
            );
            return ExitCode::from(2);
        }
    };
    match found {
        Ok(()) => ExitCode::SUCCESS,
        Err(wrong) => {
            eprintln!("stack: {wrong}");
            ExitCode::FAILURE
        }
    }
}

fn open(elf: &str) -> Result<Program, Wrong> {
    let bytes = std::fs::read(elf).map_err(|error| format!("{elf} cannot be read: {error}"))?;
    Program::read(&bytes).map_err(|wrong| format!("{elf}: {wrong}"))
}

/// Prints what was found beside its limits, and says what is beyond.
fn compare(
    graph: &Graph<'_>,
    program: &Program,
    found: &[(String, Deepest)],
    limits: &BTreeMap<String, u64>,
) -> Result<(), Wrong> {
    let mut wrong = Vec::new();
    println!("{}", graph.summary()?);
    println!(
        "{:<32} {:>7} {:>7}  deepest way, with the bytes of each frame",
        "stack of", "bytes", "limit"
    );
    for (name, deepest) in found {
        let limit = limits.get(name).copied();
        let way: Vec<_> = deepest
            .way
            .iter()
            .map(|&(at, bytes)| format!("{} {bytes}", short(program.name(at))))
            .collect();
        let shown = limit.map_or("none".to_owned(), |limit| limit.to_string());
        println!(
            "{name:<32} {:>7} {shown:>7}  {}",
            deepest.bytes,
            way.join(" > ")
        );
        match limit {
            None => wrong.push(format!("{name} has no limit")),
            Some(limit) if u64::from(deepest.bytes) > limit => {
                let bytes = deepest.bytes;
                wrong.push(format!("{name} may take {bytes} bytes, more than {limit}"));
            }
            Some(_) => {}
        }
    }
    for name in limits.keys() {
        if !found.iter().any(|(known, _)| known == name) {
            wrong.push(format!("{name} has a limit, and is not there"));
        }
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n       "))
    }
}

/// Returns a function's name without its path.
fn short(name: &str) -> String {
    let name = name.trim_start_matches('<');
    let parts: Vec<_> = name.split("::").collect();
    parts[parts.len().saturating_sub(2)..].join("::")
}

fn library(path: &str, table: &str, elf: &str, names: &[&str]) -> Result<(), Wrong> {
    let limits = limits(path, &format!("stack.{table}"))?;
    let program = open(elf)?;
    let mut graph = Graph::new(&program);
    let mut found = Vec::new();
    for &name in names {
        let at = program.symbols.get(name);
        let at = at.ok_or_else(|| format!("{elf} has no {name}"))?;
        found.push((name.to_owned(), graph.deepest(at & !1)?));
    }
    compare(&graph, &program, &found, &limits)
}

fn image(path: &str, table: &str, elf: &str, painted: Option<&str>) -> Result<(), Wrong> {
    let limits = limits(path, &format!("stack.{table}"))?;
    let program = open(elf)?;
    let mut graph = Graph::new(&program);
    let vectors = program.symbols.get("__vector_table");
    let vectors = *vectors.ok_or("the image has no __vector_table")?;
    let vector = |number: u32| program.word(vectors + 4 * number).map(|word| word & !1);
    let start = vector(1).ok_or("the vector table is empty")?;
    let thread = graph.deepest(start)?;
    let mut interrupts = BTreeMap::new();
    for handler in (2..16 + 240).map_while(vector) {
        if let Some(function) = program.functions.get(&handler)
            && !FAULTS.iter().any(|fault| function.name.starts_with(fault))
        {
            interrupts.insert(handler, graph.deepest(handler)?);
        }
    }
    let highest = interrupts.values().map(|deepest| deepest.bytes).max();
    let total = thread.bytes + highest.map_or(0, |bytes| SAVED + bytes);
    let mut found = vec![("start".to_owned(), thread)];
    for (handler, deepest) in interrupts {
        let name = short(program.name(handler)).replace("::", " ");
        found.push((format!("interrupt {name}"), deepest));
    }
    let (bytes, way) = (total, Vec::new());
    found.push(("with an interrupt".to_owned(), Deepest { bytes, way }));
    compare(&graph, &program, &found, &limits)?;
    if let Some(painted) = painted {
        let painted = painted.parse::<u32>();
        let painted = painted.map_err(|_| "PAINTED is no number of bytes")?;
        println!("painted {painted} of {total} bytes");
        if painted > total {
            return Err(format!(
                "a run took {painted} bytes, more than the {total} computed"
            ));
        }
    }
    Ok(())
}
