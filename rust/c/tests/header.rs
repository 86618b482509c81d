//! `include/popsteer.h` is what cbindgen makes of the source.
//!
//! After a change of the interface: `make declared`. cbindgen sees no struct that a macro makes:
//! those of parameters are written out for it.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

use popsteer_core::DriverParams;
use popsteer_core::Vehicle;
use popsteer_core::laws::{
    PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams,
};
use popsteer_core::params::{Field, Value};
use popsteer_core::speed::SpeedTrackerParams;
use popsteer_core::tracker::MonitorParams;
use popsteer_core::vehicle::AdaptParams;

const VEHICLE: &str = "\
All parameters of a car-like vehicle, given once. Begin with `popsteer_vehicle_default()` and
change what is known; a field marked \"NAN: ...\" need not be known.

A pose is always that of the vehicle's point, wherever it is measured; the axles are given from
there. One chain leads from a command to the motion:

    wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)
    |wheel| <= max_steer
    yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed^2)";

const OPTIONS: &str = "How a controller adapts to its vehicle, and watches it.";

const SWITCHES: &str = "\
    /// `POPSTEER_AUTO`: adapts in preview POP, and where the vehicle has a dead time;
    /// `POPSTEER_OFF`: never; `POPSTEER_ON`: with `turn_time`, `slip_time` and `speed_time`.
    pub adapt: u32,
    /// `POPSTEER_AUTO`: watches with the default numbers; `POPSTEER_OFF`: never;
    /// `POPSTEER_ON`: with `deviation_limit` and `turn_tolerance`.
    pub monitor: u32,
";

/// A text as a comment, no line longer than the others of the header.
fn comment(indent: &str, text: &str) -> String {
    let mut lines = vec![format!("{indent}///")];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= 96 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("{indent}/// {word}")),
        }
    }
    lines.join("\n") + "\n"
}

/// A struct of parameters as the library has it, with defaults and ranges in its comments.
fn written_out(
    name: &str,
    about: &str,
    first: &str,
    fields: &[Field],
) -> Result<String, Box<dyn Error>> {
    let mut text: String = about
        .lines()
        .map(|line| format!("/// {line}").trim_end().to_owned() + "\n")
        .collect();
    writeln!(text, "#[repr(C)]\npub struct {name} {{\n{first}")?;
    for field in fields {
        let (kind, default) = match field.default {
            Value::Absent if field.written == "None" => ("f64", "NAN: absent".into()),
            Value::Absent => ("f64", format!("NAN: {}", field.formula())),
            Value::Number(number) if field.optional => {
                ("f64", format!("Default {number}; NAN: absent"))
            }
            Value::Number(number) => ("f64", format!("Default {number}")),
            Value::Count(count) => ("usize", format!("Default {count}")),
            Value::Flag(flag) => ("u32", format!("0 is false. Default {}", u8::from(flag))),
        };
        let range = field
            .requirement
            .map_or_else(String::new, |range| format!(", {range}"));
        text += &comment("    ", &format!("{} {default}{range}.", field.text));
        writeln!(text, "    pub {}: {kind},", field.name)?;
    }
    Ok(text + "}\n")
}

fn parameters() -> Result<String, Box<dyn Error>> {
    let options = [&AdaptParams::fields()[..], &MonitorParams::fields()].concat();
    let laws = [
        (
            "Pop",
            "POP, the paper's controller",
            PopParams::fields().to_vec(),
        ),
        (
            "PreviewPop",
            "preview POP",
            PreviewPopParams::fields().into(),
        ),
        (
            "Pid",
            "PID on the cross-track error of the front axle",
            PidParams::fields().into(),
        ),
        (
            "PurePursuit",
            "pure pursuit of the rear axle",
            PurePursuitParams::fields().into(),
        ),
        (
            "Stanley",
            "Stanley, by the front axle",
            StanleyParams::fields().into(),
        ),
        (
            "SpeedTracker",
            "a speed tracker",
            SpeedTrackerParams::fields().into(),
        ),
        ("Driver", "a driver", DriverParams::fields().into()),
    ];
    let mut text = written_out("CVehicle", VEHICLE, "", &Vehicle::fields())?;
    text += &written_out("COptions", OPTIONS, SWITCHES, &options)?;
    for (law, what, fields) in laws {
        let about = format!("Tuning of {what}.");
        text += &written_out(&format!("C{law}Params"), &about, "", &fields)?;
    }
    Ok(text)
}

fn made(folder: &Path) -> Result<String, Box<dyn Error>> {
    let source = Path::new(env!("CARGO_TARGET_TMPDIR")).join("parameters.rs");
    fs::write(&source, parameters()?)?;
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml"))?;
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_src(source)
        .with_crate(folder)
        .generate()?;
    let mut header = Vec::new();
    bindings.write(&mut header);
    Ok(String::from_utf8(header)?)
}

#[test]
fn test_header_is_that_of_the_source() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let committed = folder.join("include/popsteer.h");
    let made = made(folder)?;
    if env::var_os("POPSTEER_WRITE").is_some() {
        fs::write(&committed, &made)?;
    }
    let committed = fs::read_to_string(committed)?;
    let difference = made
        .lines()
        .zip(committed.lines())
        .find(|(made, committed)| made != committed);
    assert!(
        made == committed,
        "popsteer.h is not that of the source (`make declared` writes it anew): {difference:?}"
    );
    Ok(())
}
