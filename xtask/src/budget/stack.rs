//! How deep the stack can get: a bound, from the machine code.
//!
//! Each function takes what its instructions push and subtract, all paths through it added up, and the deepest of what it calls. A call by
//! pointer may reach every function whose address is kept anywhere. Interrupts nest by priority: the deepest handler of each, one on top of the
//! other, with the registers that the processor itself saves.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use super::instruction::{Instruction, decode};
use crate::place;

/// What the processor saves of an interrupted program: 26 words with those of the floating-point unit, and one to align them.
const SAVED: u64 = 27 * 4;

/// Where the tasks and their priorities are written.
const TASKS: &str = "firmware/app/src/app.rs";

/// How deep the stack can get, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Depth {
    /// Before the first interrupt.
    pub start: u64,
    /// With all tasks on top of each other.
    pub tasks: u64,
}

/// The deepest the stack of this image can get; which interrupts the tasks have is written in the folder of its board.
///
/// # Errors
/// When the image cannot be read, or a handler has no priority in the sources.
pub fn worst_case(image: &Path, board: &str) -> Result<Depth> {
    let bytes = fs::read(image).with_context(|| format!("reading {}", image.display()))?;
    let file = object::File::parse(&*bytes).context("reading an ELF file")?;
    let program = Program::of(&file)?;
    let source = |name: &str| {
        let file = place::root().join(name);
        fs::read_to_string(file).with_context(|| format!("reading {name}"))
    };
    let board = format!("firmware/app/src/board/{board}/mod.rs");
    let priorities = priorities(&source(TASKS)?, &source(&board)?);

    let mut deepest: BTreeMap<u32, u64> = BTreeMap::new();
    for handler in &program.handlers {
        let names = program.names.get(handler).cloned().unwrap_or_default();
        if names.iter().any(|name| FATAL.contains(name)) {
            continue;
        }
        let priority = names.iter().find_map(|name| priorities.get(*name));
        let priority = priority.with_context(|| format!("no priority of {names:?} in {TASKS}"))?;
        let level = deepest.entry(*priority).or_default();
        *level = (*level).max(program.depth(*handler)?);
    }
    let nested: u64 = deepest.values().map(|depth| depth + SAVED).sum();
    // What waits for interrupts calls nothing.
    let named = |wanted: &str| {
        let of = |(at, names): (&u64, &Vec<&str>)| names.contains(&wanted).then_some(*at);
        let at = program.names.iter().find_map(of);
        at.with_context(|| format!("no function `{wanted}` in the image"))
    };
    let start = named("Reset")?;
    let waits = program.frame(start) + program.frame(named("main")?);
    Ok(Depth {
        start: program.depth(start)?,
        tasks: waits + nested,
    })
}

/// Handlers that end the program.
const FATAL: [&str; 9] = [
    "Reset",
    "DefaultHandler_",
    "DefaultHandler",
    "HardFault",
    "HardFaultTrampoline",
    "_HardFault",
    "NonMaskableInt",
    "DefaultPreInit",
    "main",
];

/// The priority of each interrupt that RTIC binds: a task's own, and those that it gives software tasks, the first to the highest. `$name_interrupt`
/// stands for those that the board lists as `name`.
fn priorities(tasks: &str, board: &str) -> BTreeMap<String, u32> {
    let word = |text: &str, key: &str| -> Option<String> {
        let (_, value) = text.split_once(key)?;
        let value = value.trim_start_matches([' ', '=']);
        let is_of_name = |c: &char| c.is_alphanumeric() || "_$".contains(*c);
        Some(value.chars().take_while(is_of_name).collect())
    };
    let listed = |name: &str| -> Vec<String> {
        let list = board.split_once(&format!("{name}: ["));
        let list = list.and_then(|(_, list)| list.split_once(']'));
        let (list, _) = list.unwrap_or_default();
        let interrupt = |item: &str| item.rsplit(':').next().map(|name| name.trim().to_owned());
        list.split(',').filter_map(interrupt).collect()
    };
    let mut bound = BTreeMap::new();
    let mut software = BTreeSet::new();
    for task in tasks.split("#[task(").skip(1) {
        let (task, _) = task.split_once(")]").unwrap_or((task, ""));
        let priority = word(task, "priority").and_then(|priority| priority.parse().ok());
        let priority = priority.unwrap_or(1);
        let Some(interrupt) = word(task, "binds") else {
            software.insert(priority);
            continue;
        };
        let kind = interrupt.strip_prefix('$');
        let kind = kind.and_then(|kind| kind.strip_suffix("_interrupt"));
        let interrupts = kind.map_or_else(|| vec![interrupt.clone()], listed);
        bound.extend(
            interrupts
                .into_iter()
                .map(|interrupt| (interrupt, priority)),
        );
    }
    bound.extend(
        listed("dispatchers")
            .into_iter()
            .zip(software.into_iter().rev()),
    );
    bound
}

/// A function: what it takes of the stack, and whom it may call.
#[derive(Clone, Debug, Default)]
struct Function {
    frame: u64,
    calls: BTreeSet<u64>,
    by_pointer: bool,
}

/// The functions of an image by their addresses.
#[derive(Debug)]
struct Program<'a> {
    functions: BTreeMap<u64, Function>,
    names: BTreeMap<u64, Vec<&'a str>>,
    /// Whose address is kept, so that a call by pointer may reach them.
    kept: BTreeSet<u64>,
    /// What the vector table points at.
    handlers: BTreeSet<u64>,
}

impl<'a> Program<'a> {
    fn of(file: &object::File<'a>) -> Result<Self> {
        let mut names: BTreeMap<u64, Vec<&str>> = BTreeMap::new();
        let mut ends = BTreeMap::new();
        // What is code and what is constants within a section.
        let mut is_code = BTreeMap::new();
        for symbol in file.symbols() {
            let name = symbol.name().unwrap_or_default();
            if name == "$t" || name.starts_with("$t.") {
                is_code.insert(symbol.address(), true);
            } else if name == "$d" || name.starts_with("$d.") {
                is_code.insert(symbol.address(), false);
            } else if symbol.kind() == SymbolKind::Text {
                let at = symbol.address() & !1;
                names.entry(at).or_default().push(name);
                ends.insert(at, at + symbol.size());
            }
        }
        let starts: BTreeSet<u64> = names.keys().copied().collect();

        let mut program = Self {
            functions: BTreeMap::new(),
            names,
            kept: BTreeSet::new(),
            handlers: BTreeSet::new(),
        };
        for section in file.sections() {
            let is_vectors = section.name() == Ok(".vector_table");
            let data = section.data().context("reading a section")?;
            let base = section.address();
            match section.kind() {
                SectionKind::Text => {
                    let code = Code {
                        base,
                        data,
                        is_code: &is_code,
                    };
                    let end = base + data.len() as u64;
                    for (&at, &last) in ends.range(base..end) {
                        // Assembly has no sizes: up to the next name.
                        let next = starts.range(at + 1..).next().copied().unwrap_or(end);
                        let last = if last > at { last } else { next };
                        let function = code.function(at, last, &starts, &mut program.kept)?;
                        program.functions.insert(at, function);
                    }
                }
                SectionKind::ReadOnlyData | SectionKind::Data => {
                    for word in data.chunks_exact(4) {
                        let at =
                            u64::from(u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
                        if at & 1 == 1 && starts.contains(&(at - 1)) {
                            let set = if is_vectors {
                                &mut program.handlers
                            } else {
                                &mut program.kept
                            };
                            set.insert(at - 1);
                        }
                    }
                }
                _ => {}
            }
        }
        ensure!(!program.handlers.is_empty(), "no vector table in the image");
        let handlers = &program.handlers;
        program.kept.retain(|at| !handlers.contains(at));
        Ok(program)
    }

    fn frame(&self, at: u64) -> u64 {
        self.functions.get(&at).map_or(0, |function| function.frame)
    }

    fn depth(&self, at: u64) -> Result<u64> {
        self.depth_below(at, &mut Vec::new(), &mut BTreeMap::new())
    }

    fn depth_below(
        &self,
        at: u64,
        path: &mut Vec<u64>,
        known: &mut BTreeMap<u64, u64>,
    ) -> Result<u64> {
        if let Some(depth) = known.get(&at) {
            return Ok(*depth);
        }
        let Some(function) = self.functions.get(&at) else {
            return Ok(0);
        };
        path.push(at);
        let mut below = 0;
        for call in &function.calls {
            if path.contains(call) {
                let name = self.names.get(call);
                bail!("{name:?} calls itself: there is no bound of the stack");
            }
            below = below.max(self.depth_below(*call, path, known)?);
        }
        if function.by_pointer {
            for call in &self.kept {
                // Formatting calls by pointer what formats: not the one that asked.
                if !path.contains(call) {
                    below = below.max(self.depth_below(*call, path, known)?);
                }
            }
        }
        path.pop();
        known.insert(at, function.frame + below);
        Ok(function.frame + below)
    }
}

/// The bytes of a section of code.
struct Code<'a> {
    base: u64,
    data: &'a [u8],
    is_code: &'a BTreeMap<u64, bool>,
}

impl Code<'_> {
    fn half(&self, at: u64) -> Option<u32> {
        let from = usize::try_from(at.checked_sub(self.base)?).ok()?;
        let bytes = self.data.get(from..from + 2)?;
        Some(u32::from(u16::from_le_bytes([bytes[0], bytes[1]])))
    }

    /// Where a veneer goes: what the linker puts between code in flash and code in RAM, as they are too far apart for a branch.
    fn veneer(&self, at: u64) -> Option<u64> {
        let word = |at| decode(self.half(at)?, self.half(at + 2)).ok();
        match (word(at)?, word(at + 4)?, self.half(at + 8)?) {
            (Instruction::Low(IP, low), Instruction::High(IP, high), BX_IP) => {
                Some(u64::from(low | high << 16) & !1)
            }
            _ => None,
        }
    }

    /// Reads the instructions of a function. Whose addresses it holds goes into `kept`.
    fn function(
        &self,
        start: u64,
        end: u64,
        starts: &BTreeSet<u64>,
        kept: &mut BTreeSet<u64>,
    ) -> Result<Function> {
        let mut function = Function::default();
        if let Some(target) = self.veneer(start) {
            function.calls.insert(target);
            return Ok(function);
        }
        let mut halves: BTreeMap<u32, u32> = BTreeMap::new();
        let mut keep = |address: u32| {
            let at = u64::from(address);
            if at & 1 == 1 && starts.contains(&(at - 1)) {
                kept.insert(at - 1);
            }
        };
        let mut at = start;
        while at < end {
            let Some(first) = self.half(at) else { break };
            let marked = self.is_code.range(..=at).next_back();
            if marked.is_some_and(|(_, is_code)| !is_code) {
                if let Some(second) = self.half(at + 2) {
                    keep(first | second << 16);
                }
                at += 2;
                continue;
            }
            let second = match first >> 11 {
                0b11101..=0b11111 => self.half(at + 2),
                _ => None,
            };
            match decode(first, second)? {
                Instruction::Takes(bytes) => function.frame += bytes,
                Instruction::ByPointer => function.by_pointer = true,
                Instruction::Branch(offset) => {
                    let target = (at + 4).wrapping_add_signed(offset);
                    // A jump within is a loop; a jump elsewhere, the last call of this function.
                    if !(start..end).contains(&target) {
                        let (inside, _) = starts
                            .range(..=target)
                            .next_back()
                            .map(|start| (*start, ()))
                            .context("a jump to nowhere")?;
                        function.calls.insert(inside);
                    }
                }
                Instruction::Low(register, half) => drop(halves.insert(register, half)),
                Instruction::High(register, half) => {
                    keep(halves.get(&register).copied().unwrap_or_default() | half << 16);
                }
                Instruction::Other => {}
            }
            at += if second.is_some() { 4 } else { 2 };
        }
        Ok(function)
    }
}

/// The register of a veneer, and its last instruction.
const IP: u32 = 12;
const BX_IP: u32 = 0x4760;

#[cfg(test)]
mod tests {
    use super::*;
    use Instruction::{Branch, ByPointer, High, Low, Other, Takes};

    #[test]
    fn a_veneer_is_a_call() {
        let is_code = BTreeMap::new();
        let at = |data: &[u8]| {
            let code = Code {
                base: 0x100,
                data,
                is_code: &is_code,
            };
            code.veneer(0x100)
        };
        // movw ip, #0x1235; movt ip, #0x0801; bx ip
        let mut veneer = *b"\x41\xf2\x35\x2c\xc0\xf6\x01\x0c\x60\x47";
        assert_eq!(at(&veneer), Some(0x0801_1234));
        // To where it came from.
        veneer[8] = 0x70;
        assert_eq!(at(&veneer), None);
    }

    #[test]
    fn what_takes_of_the_stack_is_seen() {
        let decode = |first, second| decode(first, second).unwrap();
        assert_eq!(decode(0xB5F0, None), Takes(20)); // push {r4-r7, lr}
        assert_eq!(decode(0xB082, None), Takes(8)); // sub sp, #8
        assert_eq!(decode(0xE92D, Some(0x4FF0)), Takes(36)); // push.w {r4-r11, lr}
        assert_eq!(decode(0xF84D, Some(0x8D04)), Takes(4)); // str r8, [sp, #-4]!
        assert_eq!(decode(0xED2D, Some(0x8B04)), Takes(16)); // vpush {d8, d9}
        assert_eq!(decode(0xF5AD, Some(0x7D16)), Takes(600)); // sub.w sp, sp, #600
        assert_eq!(decode(0xF2AD, Some(0x4D14)), Takes(1044)); // subw sp, sp, #1044
        assert_eq!(decode(0xB002, None), Other); // add sp, #8
        assert!(super::decode(0xEBAD, Some(0x0D00)).is_err()); // sub.w sp, sp, r0
    }

    #[test]
    fn calls_and_addresses_are_seen() {
        let decode = |first, second| decode(first, second).unwrap();
        assert_eq!(decode(0xF7FF, Some(0xFFFE)), Branch(-4)); // bl to itself
        assert_eq!(decode(0xF000, Some(0xF802)), Branch(4)); // bl
        assert_eq!(decode(0xF000, Some(0xB802)), Branch(4)); // b.w
        assert_eq!(decode(0xF43F, Some(0xAFFE)), Branch(-4)); // beq.w
        assert_eq!(decode(0xE7FE, None), Branch(-4)); // b
        assert_eq!(decode(0xD0FE, None), Branch(-4)); // beq
        assert_eq!(decode(0x4788, None), ByPointer); // blx r1
        assert_eq!(decode(0x4770, None), Other); // bx lr
        assert_eq!(decode(0xF241, Some(0x2034)), Low(0, 0x1234)); // movw r0, #0x1234
        assert_eq!(decode(0xF6C0, Some(0x0101)), High(1, 0x0801)); // movt r1, #0x801
    }

    #[test]
    fn software_tasks_have_the_dispatchers_from_the_highest_on() {
        let tasks = "\
    #[task(binds = $pulses_interrupt, priority = 5, shared = [step])]
    #[task(binds = SysTick, priority = 3, shared = [control])]
    #[task(priority = 1, local = [panel])]
    #[task(priority = 3)]
";
        let board = "\
    dispatchers: [SPI1, SPI2],
    pulses: [cut_off: TIM1, step: TIM2],
";
        let priorities = priorities(tasks, board);
        let expected = [
            ("SPI1", 3),
            ("SPI2", 1),
            ("SysTick", 3),
            ("TIM1", 5),
            ("TIM2", 5),
        ];
        assert!(
            priorities
                .iter()
                .map(|(name, priority)| (name.as_str(), *priority))
                .eq(expected)
        );
    }
}
