//! The exports of the playground on this machine, to be compared with the module in a browser.
//!
//! Each line of the input is a call and its numbers, as the 16 hexadecimal digits of their bits:
//! `open`, `closed` or `draw` and a track, or the name of a controller and the settings. Each
//! answer is a line of the same: the output's numbers, or the message of a refusal.

use std::io::{self, BufWriter, Write, read_to_string, stdin, stdout};

use popsteer_wasm::{Session, Text};

fn main() -> io::Result<()> {
    let mut session = Session::default();
    let controllers = session.text(Text::Controllers).to_owned();
    let mut out = BufWriter::new(stdout().lock());
    for line in read_to_string(stdin())?.lines() {
        let mut words = line.split_whitespace();
        let call = words.next().unwrap_or("");
        let numbers: Result<Vec<f64>, _> = words
            .map(|digits| u64::from_str_radix(digits, 16).map(f64::from_bits))
            .collect();
        let numbers = numbers.map_err(io::Error::other)?;
        if let Some(room) = session.room(numbers.len()) {
            room.copy_from_slice(&numbers);
        }
        let controller = controllers.split(',').position(|name| name == call);
        let done = match (call, controller) {
            ("open" | "closed", _) => session.track(call == "closed"),
            ("draw", _) => session.draw().is_some(),
            (_, controller) => session.drive(controller.unwrap_or(usize::MAX)),
        };
        if !done {
            writeln!(out, "{}", session.text(Text::Message))?;
            continue;
        }
        let bits = session.output().iter().map(|number| number.to_bits());
        let digits: Vec<String> = bits.map(|bits| format!("{bits:016x}")).collect();
        writeln!(out, "{}", digits.join(" "))?;
    }
    out.flush()
}
