//! The functions of a linked program for a Cortex-M, and their instructions.

use capstone::arch::arm::{ArchExtraMode, ArchMode, ArmOperandType};
use capstone::prelude::*;
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An error's text.
pub(crate) type Wrong = String;

/// One instruction.
#[derive(Debug, Clone)]
pub(crate) struct Instruction {
    pub(crate) at: u32,
    /// Length in bytes: 2 or 4.
    pub(crate) length: u32,
    /// Mnemonic without condition and width.
    pub(crate) name: String,
    pub(crate) conditional: bool,
    pub(crate) operands: Vec<Operand>,
    /// The instruction as a person reads it.
    pub(crate) text: String,
}

/// An operand of an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Operand {
    /// r0 to r12, sp, lr and pc by number; `None` for others.
    Register(Option<usize>),
    Number(i32),
    /// A place in memory: base register and offset.
    Memory(Option<usize>, i32),
    /// A place in memory with an index register: its base register.
    Indexed(Option<usize>),
    /// An operand that matters neither to stack frames nor to calls.
    Other,
}

pub(crate) const SP: usize = 13;
pub(crate) const LR: usize = 14;
pub(crate) const PC: usize = 15;

/// A function of the program.
#[derive(Debug)]
pub(crate) struct Function {
    pub(crate) name: String,
    /// The address past its last byte.
    pub(crate) end: u32,
    /// Instructions by address.
    pub(crate) instructions: BTreeMap<u32, Instruction>,
}

/// A linked program.
pub(crate) struct Program {
    /// Functions by address.
    pub(crate) functions: BTreeMap<u32, Function>,
    /// Functions that any call through a pointer may reach: their addresses are in the program's
    /// data, in the constants between its functions, or built by instructions.
    pub(crate) taken: BTreeSet<u32>,
    /// Functions in the method tables of trait objects, by their offset: only a load at that
    /// offset reaches them.
    pub(crate) methods: BTreeMap<i32, BTreeSet<u32>>,
    pub(crate) symbols: HashMap<String, u32>,
    sections: Vec<(u32, Vec<u8>, bool)>,
    /// Addresses at which data begins within code, and at which code begins again.
    marks: BTreeMap<u32, bool>,
}

impl Program {
    /// Reads an ELF file.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, Wrong> {
        let file = object::File::parse(bytes).map_err(|error| error.to_string())?;
        let mut sections = Vec::new();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                continue;
            };
            let allocated = sh_flags & u64::from(object::elf::SHF_ALLOC) != 0;
            let data = section.data().map_err(|error| error.to_string())?;
            // The hardware calls the vectors' functions, not a pointer.
            let hardware = section.name().is_ok_and(|name| name.contains("vector"));
            if allocated && !data.is_empty() {
                sections.push((section.address() as u32, data.to_vec(), hardware));
            }
        }
        let mut marks = BTreeMap::new();
        let mut names: BTreeMap<u32, (String, u32)> = BTreeMap::new();
        let mut symbols = HashMap::new();
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let at = symbol.address() as u32;
            match name.get(..2) {
                Some("$t") => drop(marks.insert(at, true)),
                Some("$d") => drop(marks.insert(at, false)),
                _ => {}
            }
            if !name.starts_with('$') {
                symbols.insert(name.to_owned(), at);
            }
            let is_code = symbol.kind() == SymbolKind::Text;
            if is_code && symbol.is_definition() && !name.starts_with('$') {
                // The name without the hash that the compiler adds.
                let readable = format!("{:#}", rustc_demangle::demangle(name));
                let entry = (readable, symbol.size() as u32);
                let place = names.entry(at & !1).or_insert_with(|| entry.clone());
                if place.1 < entry.1 {
                    *place = entry;
                }
            }
        }
        let mut program = Self {
            functions: BTreeMap::new(),
            taken: BTreeSet::new(),
            methods: BTreeMap::new(),
            symbols,
            sections,
            marks,
        };
        program.decode(&names)?;
        program.find_taken();
        Ok(program)
    }

    /// Returns the word at an address.
    pub(crate) fn word(&self, at: u32) -> Option<u32> {
        let bytes = self.bytes(at, 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }

    /// Returns the bytes at an address.
    pub(crate) fn bytes(&self, at: u32, count: usize) -> Option<&[u8]> {
        self.sections.iter().find_map(|(start, data, _)| {
            let offset = at.checked_sub(*start)? as usize;
            data.get(offset..offset.checked_add(count)?)
        })
    }

    /// Returns where the data that begins at an address ends and code goes on.
    pub(crate) fn data_end(&self, at: u32) -> u32 {
        let next = self.marks.range(at..).find(|&(_, &code)| code);
        next.map_or(at, |(&end, _)| end)
    }

    pub(crate) fn name(&self, at: u32) -> &str {
        self.functions.get(&at).map_or("?", |it| &it.name)
    }

    fn decode(&mut self, names: &BTreeMap<u32, (String, u32)>) -> Result<(), Wrong> {
        let decoder = Capstone::new()
            .arm()
            .mode(ArchMode::Thumb)
            .extra_mode([ArchExtraMode::MClass, ArchExtraMode::V8].into_iter())
            .detail(true)
            .build()
            .map_err(|error| error.to_string())?;
        for (&start, (name, size)) in names {
            let next = names.range(start + 1..).next().map(|(&next, _)| next);
            // The symbol of a function in assembly may have no length.
            let end = match (size, next) {
                (0, Some(next)) => next,
                (0, None) => self.data_end(start + 1).max(start),
                (_, _) => start + size,
            };
            let mut instructions = BTreeMap::new();
            for (from, to) in self.runs(start, end) {
                let Some(bytes) = self.bytes(from, (to - from) as usize) else {
                    continue;
                };
                decode_run(&decoder, bytes, from, &mut instructions)?;
            }
            if !instructions.is_empty() {
                let name = name.clone();
                let function = Function {
                    name,
                    end,
                    instructions,
                };
                self.functions.insert(start, function);
            }
        }
        Ok(())
    }

    /// Returns the parts of a function that are code.
    fn runs(&self, start: u32, end: u32) -> Vec<(u32, u32)> {
        let before = self.marks.range(..=start).next_back();
        let mut is_code = before.is_none_or(|(_, &code)| code);
        let mut from = start;
        let mut runs = Vec::new();
        for (&at, &code) in self.marks.range(start + 1..end) {
            if is_code && !code {
                runs.push((from, at));
            } else if !is_code && code {
                from = at;
            }
            is_code = code;
        }
        if is_code {
            runs.push((from, end));
        }
        runs
    }

    fn find_taken(&mut self) {
        let is_function = |word: u32| word & 1 == 1 && self.functions.contains_key(&(word & !1));
        let mut taken = BTreeSet::new();
        let mut methods: BTreeMap<i32, BTreeSet<u32>> = BTreeMap::new();
        let begins = |at: u32| {
            let function = self.functions.range(..=at).next_back();
            function.is_some_and(|(_, one)| one.instructions.contains_key(&at))
        };
        for (start, data, hardware) in &self.sections {
            if *hardware {
                continue;
            }
            // Code is searched, too: constants lie between its instructions.
            let words = data.as_chunks::<4>().0;
            let words: Vec<u32> = words.iter().map(|&word| u32::from_le_bytes(word)).collect();
            let mut at = 0;
            while let Some(&word) = words.get(at) {
                if begins(start + 4 * at as u32) {
                    at += 1;
                    continue;
                }
                let rest = &words[at..];
                let count = methods_of(rest, &is_function);
                for (offset, &method) in (0..).step_by(4).zip(&rest[..count]) {
                    if is_function(method) {
                        methods.entry(offset).or_default().insert(method & !1);
                    }
                }
                if count == 0 && is_function(word) {
                    taken.insert(word & !1);
                }
                at += count.max(1);
            }
        }
        for function in self.functions.values() {
            let mut low: BTreeMap<usize, BTreeSet<u32>> = BTreeMap::new();
            let mut high: BTreeMap<usize, BTreeSet<u32>> = BTreeMap::new();
            for instruction in function.instructions.values() {
                let [Operand::Register(Some(to)), Operand::Number(number)] =
                    instruction.operands[..]
                else {
                    continue;
                };
                let number = number as u32;
                match instruction.name.as_str() {
                    "movw" => drop(low.entry(to).or_default().insert(number)),
                    "movt" => drop(high.entry(to).or_default().insert(number & 0xffff)),
                    "adr" => {
                        let address = (instruction.at & !3) + 4 + number;
                        if self.functions.contains_key(&(address & !1)) {
                            taken.insert(address & !1);
                        }
                    }
                    _ => {}
                }
            }
            for (to, low) in low {
                let high = high.get(&to).into_iter().flatten();
                let pairs = high.flat_map(|high| low.iter().map(move |low| high << 16 | low));
                taken.extend(
                    pairs
                        .filter(|&word| is_function(word))
                        .map(|word| word & !1),
                );
            }
        }
        self.taken = taken;
        self.methods = methods;
    }
}

/// Returns the number of words of a trait object's method table that begins here, or 0: its drop
/// function or 0, its size, its alignment, then one method or more.
fn methods_of(words: &[u32], is_function: &impl Fn(u32) -> bool) -> usize {
    let begins = |words: &[u32]| match words {
        &[drop, size, align, method, ..] => {
            (drop == 0 || is_function(drop))
                && align.is_power_of_two()
                && align <= 64
                && size < 1 << 16
                && size % align == 0
                && is_function(method)
        }
        _ => false,
    };
    if !begins(words) {
        return 0;
    }
    let more = (4..words.len()).take_while(|&at| is_function(words[at]) && !begins(&words[at..]));
    4 + more.count()
}

fn decode_run(
    decoder: &Capstone,
    bytes: &[u8],
    from: u32,
    into: &mut BTreeMap<u32, Instruction>,
) -> Result<(), Wrong> {
    let decoded = decoder.disasm_all(bytes, u64::from(from));
    let decoded = decoded.map_err(|error| error.to_string())?;
    let mut end = from;
    for instruction in decoded.iter() {
        let at = instruction.address() as u32;
        let detail = decoder.insn_detail(instruction);
        let detail = detail.map_err(|error| error.to_string())?;
        let detail = detail.arch_detail();
        let detail = detail.arm().ok_or("no instruction of an Arm")?;
        let operand = |operand: capstone::arch::arm::ArmOperand| match operand.op_type {
            ArmOperandType::Reg(register) => Operand::Register(number(decoder, register)),
            ArmOperandType::Imm(number) => Operand::Number(number),
            ArmOperandType::Mem(memory) if memory.index().0 != 0 => {
                Operand::Indexed(number(decoder, memory.base()))
            }
            ArmOperandType::Mem(memory) => {
                Operand::Memory(number(decoder, memory.base()), memory.disp())
            }
            _ => Operand::Other,
        };
        let mnemonic = instruction.mnemonic().unwrap_or_default();
        let name = mnemonic.split('.').next().unwrap_or_default();
        let condition = format!("{:?}", detail.cc());
        let condition = condition.trim_start_matches("ARM_CC_").to_lowercase();
        let conditional = condition != "al" && condition != "invalid";
        let name = match name.strip_suffix(condition.as_str()) {
            Some(bare) if conditional && !bare.is_empty() => bare,
            _ => name,
        };
        let length = instruction.len() as u32;
        end = at + length;
        let decoded = Instruction {
            at,
            length,
            name: name.to_owned(),
            conditional,
            operands: detail.operands().map(operand).collect(),
            text: format!("{mnemonic} {}", instruction.op_str().unwrap_or_default()),
        };
        into.insert(at, decoded);
    }
    // Padding after the last instruction.
    let rest = bytes.get((end - from) as usize..).unwrap_or_default();
    if rest.iter().any(|&byte| byte != 0) {
        return Err(format!("the instruction at {end:#x} cannot be decoded"));
    }
    Ok(())
}

/// Returns the number of a general register.
fn number(decoder: &Capstone, register: RegId) -> Option<usize> {
    let name = decoder.reg_name(register)?;
    match name.as_str() {
        "sb" => Some(9),
        "sl" => Some(10),
        "fp" => Some(11),
        "ip" => Some(12),
        "sp" => Some(SP),
        "lr" => Some(LR),
        "pc" => Some(PC),
        name => name.strip_prefix('r')?.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_table_is_told_from_other_words() {
        let is_function = |word: u32| word == 0x101 || word == 0x201;
        let table = [0, 8, 4, 0x101, 0x201, 7];
        assert_eq!(methods_of(&table, &is_function), 5);
        // A table with a drop function; the function behind it belongs to the next.
        let two = [0x201, 12, 4, 0x101, 0x201, 8, 4, 0x101];
        assert_eq!(methods_of(&two, &is_function), 4);
        for other in [
            [0, 6, 4, 0x101],
            [0, 8, 3, 0x101],
            [0, 8, 4, 5],
            [9, 8, 4, 0x101],
        ] {
            assert_eq!(methods_of(&other, &is_function), 0, "{other:?}");
        }
        assert_eq!(methods_of(&[0, 8, 4], &is_function), 0);
    }
}
