//! Lines as rustfmt writes them.

/// The most columns of a line.
const WIDTH: usize = 100;

/// The head of a function: `pub fn name(&self, value: u8) -> u8 {`, one argument on each line where that is too long.
/// `start` is everything before the arguments, `result` the type behind them or nothing.
pub(super) fn head(indent: usize, start: &str, arguments: &[&str], result: &str) -> String {
    declaration(indent, start, arguments, result, " {\n")
}

/// The same without a body.
pub(super) fn signature(indent: usize, start: &str, arguments: &[&str], result: &str) -> String {
    declaration(indent, start, arguments, result, ";\n")
}

fn declaration(indent: usize, start: &str, arguments: &[&str], result: &str, end: &str) -> String {
    let space = " ".repeat(indent);
    let result = if result.is_empty() {
        String::new()
    } else {
        format!(" -> {result}")
    };
    let line = format!("{space}{start}({}){result}", arguments.join(", "));
    if columns(&line) + end.trim_end().len() <= WIDTH {
        return line + end;
    }
    let lines: String = arguments
        .iter()
        .map(|argument| format!("{space}    {argument},\n"))
        .collect();
    format!("{space}{start}(\n{lines}{space}){result}{end}")
}

/// A constant: `pub const NAME: u16 = 0x1000;`, its value on a line of its own where that is too long.
pub(super) fn constant(indent: usize, start: &str, value: &str) -> String {
    let space = " ".repeat(indent);
    let line = format!("{space}{start} = {value};\n");
    if columns(&line) <= WIDTH + 1 {
        line
    } else {
        format!("{space}{start} =\n{space}    {value};\n")
    }
}

fn columns(line: &str) -> usize {
    line.chars().count()
}
