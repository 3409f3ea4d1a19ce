//! How deep a function's own frame is at each of its instructions.
//!
//! The stack pointer is followed along every way through a function. Where ways
//! meet the deeper one counts. What moves the stack pointer in a way that is not
//! followed here is an error, never a guess.

use crate::code::{Function, Instruction, LR, Operand, PC, Program, SP, Wrong};
use std::collections::BTreeMap;

/// What a function takes, and what it calls with how much of that.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// Bytes at its deepest.
    pub(crate) bytes: u32,
    /// Most bytes taken where it calls each.
    pub(crate) calls: BTreeMap<Callee, u32>,
}

/// What is called, or jumped to for good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Callee {
    /// The function at an address.
    Function(u32),
    /// Wherever a pointer leads that was loaded at an offset from another, or
    /// where that is not known.
    Pointer(Option<i32>),
}

/// Frames beyond this are taken for endless.
const MOST: i64 = 1 << 20;

/// What is known of a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Value {
    Unknown,
    /// So many bytes under where the stack pointer was at first.
    Depth(i64),
    Number(u32),
    /// Loaded at an offset from a pointer.
    Loaded(i32),
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct State {
    depth: i64,
    registers: [Value; 16],
    /// What was put aside on the stack, by its depth there.
    aside: BTreeMap<i64, Value>,
}

impl State {
    /// Returns what holds wherever one of both does.
    fn join(&self, other: &Self) -> Self {
        let mut registers = self.registers;
        for (own, theirs) in registers.iter_mut().zip(&other.registers) {
            if own != theirs {
                *own = Value::Unknown;
            }
        }
        let mut aside = self.aside.clone();
        aside.retain(|at, value| other.aside.get(at) == Some(&*value));
        Self {
            depth: self.depth.max(other.depth),
            registers,
            aside,
        }
    }

    fn get(&self, register: usize) -> Value {
        if register == SP {
            Value::Depth(self.depth)
        } else {
            self.registers[register]
        }
    }

    fn set(&mut self, instruction: &Instruction, to: usize, value: Value) -> Result<(), Wrong> {
        if to != SP {
            self.registers[to] = value;
            return Ok(());
        }
        let Value::Depth(depth) = value else {
            return Err(unknown(instruction, "moves the stack pointer anywhere"));
        };
        self.depth = depth;
        Ok(())
    }
}

fn unknown(instruction: &Instruction, what: &str) -> Wrong {
    format!("`{}` at {:#x} {what}", instruction.text, instruction.at)
}

/// Where control goes after an instruction.
enum After {
    Next,
    /// There alone, or on as well.
    Jump(Vec<u32>, bool),
    /// To a function, and on.
    Call(Callee),
    /// Out of the function for good.
    Leave(Option<Callee>),
}

/// Follows a function from its first instruction to all that can be reached.
pub(crate) fn frame(program: &Program, start: u32) -> Result<Frame, Wrong> {
    let function = program.functions.get(&start);
    let function = function.ok_or_else(|| format!("no function is at {start:#x}"))?;
    follow(program, start, function).map_err(|wrong| format!("{}: {wrong}", function.name))
}

fn follow(program: &Program, start: u32, function: &Function) -> Result<Frame, Wrong> {
    let first = State {
        depth: 0,
        registers: [Value::Unknown; 16],
        aside: BTreeMap::new(),
    };
    let mut states = BTreeMap::from([(start, first)]);
    let mut open = vec![start];
    let mut frame = Frame::default();
    while let Some(at) = open.pop() {
        let Some(instruction) = function.instructions.get(&at) else {
            return Err(format!("runs into what is no instruction at {at:#x}"));
        };
        let before = states[&at].clone();
        let mut after = before.clone();
        apply(program, instruction, &mut after)?;
        if instruction.conditional {
            after = after.join(&before);
        }
        if after.depth > MOST {
            return Err(unknown(instruction, "takes more and more of the stack"));
        }
        frame.bytes = frame.bytes.max(after.depth.max(0) as u32);
        let next = at + instruction.length;
        let mut targets = Vec::new();
        let mut note = |callee: Callee| {
            let bytes = frame.calls.entry(callee).or_default();
            *bytes = (*bytes).max(before.depth.max(0) as u32);
        };
        match control(program, function, instruction, &before)? {
            After::Next => targets.push(next),
            After::Jump(to, on) => {
                for to in to {
                    if (start..function.end).contains(&to) {
                        targets.push(to);
                    } else {
                        note(Callee::Function(to));
                    }
                }
                if on {
                    targets.push(next);
                }
            }
            After::Call(callee) => {
                note(callee);
                for register in [0, 1, 2, 3, 12, LR] {
                    after.registers[register] = Value::Unknown;
                }
                // Behind a call of what never returns there may be anything else.
                if function.instructions.contains_key(&next) {
                    targets.push(next);
                }
            }
            After::Leave(callee) => {
                callee.map(&mut note);
                if instruction.conditional {
                    targets.push(next);
                }
            }
        }
        for to in targets {
            // Some functions of an assembler go on into what follows them.
            if to >= function.end && program.functions.contains_key(&to) {
                note(Callee::Function(to));
                continue;
            }
            let known = states.get(&to);
            let joined = known.map_or_else(|| after.clone(), |known| known.join(&after));
            if known != Some(&joined) {
                states.insert(to, joined);
                open.push(to);
            }
        }
    }
    Ok(frame)
}

/// Returns whether an instruction is one that grows or shrinks the stack as it stores or
/// loads, which it then has done.
fn pushes(instruction: &Instruction, state: &mut State) -> bool {
    use Operand::{Memory, Number, Register};
    let operands = instruction.operands.as_slice();
    let registers = |list: &[Operand], each: i64| each * list.len() as i64;
    let vector = if instruction.text.contains('d') { 8 } else { 4 };
    match (instruction.name.as_str(), operands) {
        ("push", list) => state.depth += registers(list, 4),
        ("pop", list) => {
            forget(list, state);
            state.depth -= registers(list, 4);
        }
        ("vpush", list) => state.depth += registers(list, vector),
        ("vpop", list) => state.depth -= registers(list, vector),
        ("stmdb", [Register(Some(SP)), list @ ..]) if is_written_back(instruction) => {
            state.depth += registers(list, 4);
        }
        ("ldm" | "ldmia", [Register(Some(SP)), list @ ..]) if is_written_back(instruction) => {
            forget(list, state);
            state.depth -= registers(list, 4);
        }
        (
            "str" | "strd" | "ldr" | "ldrd",
            [.., Memory(Some(SP), by)] | [.., Memory(Some(SP), _), Number(by)],
        ) if is_written_back(instruction) || matches!(operands, [.., Number(_)]) => {
            if instruction.name.starts_with("ldr") {
                forget(operands, state);
            }
            state.depth -= i64::from(*by);
        }
        _ => return false,
    }
    true
}

/// Returns whether an instruction stores to the stack or loads what is followed, which it
/// then has done.
fn moves(program: &Program, instruction: &Instruction, state: &mut State) -> Result<bool, Wrong> {
    use Operand::{Memory, Register};
    match (instruction.name.as_str(), instruction.operands.as_slice()) {
        ("ldr", [Register(Some(to)), Memory(Some(PC), by)]) if *to != PC => {
            let at = (instruction.at & !3)
                .wrapping_add(4)
                .wrapping_add_signed(*by);
            let value = program.word(at).map_or(Value::Unknown, Value::Number);
            state.set(instruction, *to, value)?;
        }
        ("str" | "strd", [stored @ .., Memory(Some(SP), by)]) => {
            for (place, operand) in (0..).zip(stored) {
                let at = state.depth - i64::from(*by) - 4 * place;
                let value = match operand {
                    Register(Some(from)) => state.get(*from),
                    _ => Value::Unknown,
                };
                state.aside.insert(at, value);
            }
        }
        ("stm" | "stmia", [Register(Some(SP)), stored @ ..]) if !is_written_back(instruction) => {
            for (place, operand) in (0..).zip(stored) {
                if let Register(Some(from)) = operand {
                    state
                        .aside
                        .insert(state.depth - 4 * place, state.get(*from));
                }
            }
        }
        ("ldr" | "ldrd", [loaded @ .., Memory(from, by)])
            if !is_written_back(instruction) && !loaded.contains(&Register(Some(PC))) =>
        {
            let values: Vec<_> = (0..loaded.len())
                .map(|place| {
                    let by = by + 4 * place as i32;
                    match from {
                        Some(SP) => {
                            let at = state.depth - i64::from(by);
                            state.aside.get(&at).copied().unwrap_or(Value::Unknown)
                        }
                        Some(PC) => Value::Unknown,
                        _ => Value::Loaded(by),
                    }
                })
                .collect();
            for (operand, value) in loaded.iter().zip(values) {
                if let Register(Some(to)) = operand {
                    state.set(instruction, *to, value)?;
                }
            }
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Returns what an instruction does to the registers that are followed.
// Longer than 80 lines: an arm for each kind of instruction.
fn apply(program: &Program, instruction: &Instruction, state: &mut State) -> Result<(), Wrong> {
    use Operand::{Memory, Number, Register};
    if pushes(instruction, state) || moves(program, instruction, state)? {
        return Ok(());
    }
    let deeper = |value: Value, by: i64| match value {
        Value::Depth(depth) => Value::Depth(depth + by),
        _ => Value::Unknown,
    };
    let operands = instruction.operands.as_slice();
    match (instruction.name.as_str(), operands) {
        ("sub" | "subw" | "add" | "addw" | "adds" | "subs", [Register(Some(to)), rest @ ..])
            if matches!(rest, [Number(_)] | [Register(Some(_)), Number(_)]) =>
        {
            let (from, by) = match rest {
                [Register(Some(from)), Number(by)] => (*from, *by),
                [Number(by)] => (*to, *by),
                _ => return Err(unknown(instruction, "is not understood")),
            };
            let is_up = instruction.name.starts_with("add");
            let by = if is_up { -i64::from(by) } else { by.into() };
            state.set(instruction, *to, deeper(state.get(from), by))?;
        }
        // Aligned downwards.
        ("bfc", [Register(Some(to)), Number(0), Number(bits)]) => {
            let by = (1_i64 << bits) - 1;
            state.set(instruction, *to, deeper(state.get(*to), by))?;
        }
        ("bic", [Register(Some(to)), Register(Some(from)), Number(mask)]) => {
            state.set(instruction, *to, deeper(state.get(*from), (*mask).into()))?;
        }
        ("mov", [Register(Some(to)), Register(Some(from))]) if *to != PC => {
            state.set(instruction, *to, state.get(*from))?;
        }
        ("mov" | "movs" | "movw", [Register(Some(to)), Number(number)]) => {
            state.set(instruction, *to, Value::Number(*number as u32))?;
        }
        ("movt", [Register(Some(to)), Number(number)]) => {
            let value = match state.get(*to) {
                Value::Number(low) => Value::Number(low & 0xffff | (*number as u32) << 16),
                _ => Value::Unknown,
            };
            state.set(instruction, *to, value)?;
        }
        // Special registers: another stack pointer would be another stack.
        ("msr", _) if instruction.text.contains("sp") => {
            return Err(unknown(instruction, "changes stacks"));
        }
        _ => {
            forget(written(instruction), state);
            if is_written_back(instruction) || operands.len() > 2 {
                for operand in operands {
                    if let Memory(Some(base), _) | Operand::Indexed(Some(base)) = operand
                        && *base != SP
                    {
                        state.registers[*base] = Value::Unknown;
                    }
                }
            }
            // Other stores to the stack may be to what was put aside.
            if let Some(Memory(Some(SP), by)) = operands.last() {
                let from = state.depth - i64::from(*by);
                state
                    .aside
                    .retain(|&at, _| !(from - 16..from + 4).contains(&at));
            }
            let writes = matches!(operands.first(), Some(Register(Some(SP))));
            if writes || operands.last() == Some(&Operand::Indexed(Some(SP))) {
                state.aside.clear();
            }
            let reads = [
                "cmp", "cmn", "tst", "ldm", "ldmia", "stm", "vstmia", "vldmia",
            ];
            if writes
                && (!reads.contains(&instruction.name.as_str()) || is_written_back(instruction))
            {
                return Err(unknown(instruction, "moves the stack pointer"));
            }
            if is_written_back(instruction) && matches!(operands, [.., Memory(Some(SP), _)]) {
                return Err(unknown(instruction, "moves the stack pointer"));
            }
        }
    }
    Ok(())
}

/// Returns the operands to which an instruction may write.
fn written(instruction: &Instruction) -> &[Operand] {
    let all = instruction.operands.as_slice();
    let name = instruction.name.as_str();
    let starts = |with: &[&str]| with.iter().any(|start| name.starts_with(start));
    if starts(&[
        "cmp", "cmn", "tst", "teq", "str", "vst", "vcmp", "blx", "bx", "cb",
    ]) {
        &[]
    } else if starts(&[
        "ldm", "stm", "ldrd", "ldrex", "umull", "umlal", "umaal", "smull", "smlal", "vmov",
    ]) {
        all
    } else {
        all.get(..1).unwrap_or_default()
    }
}

fn is_written_back(instruction: &Instruction) -> bool {
    instruction.text.contains('!')
}

fn forget(list: &[Operand], state: &mut State) {
    for operand in list {
        if let Operand::Register(Some(register)) = operand
            && *register != SP
        {
            state.registers[*register] = Value::Unknown;
        }
    }
}

/// Returns where control goes.
fn control(
    program: &Program,
    function: &Function,
    instruction: &Instruction,
    state: &State,
) -> Result<After, Wrong> {
    use Operand::{Memory, Number, Register};
    let by = |register: usize| match state.get(register) {
        Value::Number(at) if program.functions.contains_key(&(at & !1)) => {
            Callee::Function(at & !1)
        }
        Value::Loaded(offset) => Callee::Pointer(Some(offset)),
        _ => Callee::Pointer(None),
    };
    Ok(
        match (instruction.name.as_str(), instruction.operands.as_slice()) {
            ("b", [Number(to)]) => After::Jump(vec![*to as u32], instruction.conditional),
            ("cbz" | "cbnz", [_, Number(to)]) => After::Jump(vec![*to as u32], true),
            ("bl" | "blx", [Number(to)]) => After::Call(Callee::Function(*to as u32 & !1)),
            ("blx", [Register(Some(register))]) => After::Call(by(*register)),
            ("bx", [Register(Some(LR))])
            | ("ldr", [Register(Some(PC)), Memory(Some(SP), _), ..])
            | ("udf" | "trap", _) => After::Leave(None),
            ("bx", [Register(Some(register))]) => After::Leave(Some(by(*register))),
            ("pop", list) | ("ldm" | "ldmia", [Register(Some(SP)), list @ ..])
                if list.contains(&Register(Some(PC))) =>
            {
                After::Leave(None)
            }
            ("ldm" | "ldmia" | "ldmdb", list) if list.contains(&Register(Some(PC))) => {
                return Err(unknown(instruction, "jumps to nobody knows where"));
            }
            ("tbb", _) => After::Jump(table(program, function, instruction, 1)?, false),
            ("tbh", _) => After::Jump(table(program, function, instruction, 2)?, false),
            (_, [Register(Some(PC)), ..])
                if !["cmp", "str", "push"].contains(&instruction.name.as_str()) =>
            {
                return Err(unknown(instruction, "jumps to nobody knows where"));
            }
            _ => After::Next,
        },
    )
}

/// Returns the places of the function that a table of a switch leads to: it lies behind
/// its jump. Constants may follow it: taking them for more of it is safe.
fn table(
    program: &Program,
    function: &Function,
    instruction: &Instruction,
    width: usize,
) -> Result<Vec<u32>, Wrong> {
    let base = instruction.at + 4;
    let size = program.data_end(base) - base;
    let bytes = program.bytes(base, size as usize);
    let bytes = bytes.filter(|bytes| !bytes.is_empty());
    let bytes = bytes.ok_or_else(|| unknown(instruction, "has no table"))?;
    let entries = bytes.chunks_exact(width).map(|entry| match entry {
        [byte] => u32::from(*byte),
        [low, high] => u32::from(u16::from_le_bytes([*low, *high])),
        _ => 0,
    });
    let mut places: Vec<u32> = entries.map(|entry| base + 2 * entry).collect();
    places.retain(|place| function.instructions.contains_key(place));
    if places.is_empty() {
        return Err(unknown(instruction, "has an empty table"));
    }
    Ok(places)
}
