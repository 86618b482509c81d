//! What else has the parameters has them from their declarations: the stub's classes in
//! `python/popsteer/_core.pyi` and the tables of `docs/parameters.md`.
//!
//! After a change of a parameter: `make declared`.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

use popsteer_core::DriverParams;
use popsteer_core::laws::{
    PidParams, PopParams, PreviewPopParams, PurePursuitParams, StanleyParams,
};
use popsteer_core::params::{Field, Value};
use popsteer_core::speed::{CoupledLongitudinalParams, SpeedPidParams, SpeedTrackerParams};
use popsteer_core::tracker::MonitorParams;
use popsteer_core::vehicle::{AdaptParams, Vehicle};
use popsteer_sim::plant::{CarlaIdentified, KinematicBicycle};
use popsteer_sim::{Noise, Settings};

/// A class of parameters in Python: its name, its base in the stub, and its fields.
type Class = (&'static str, &'static str, Vec<Field>);

macro_rules! classes {
    ($($name:ident: $base:literal),+ $(,)?) => {
        vec![$((stringify!($name), $base, $name::fields().into())),+]
    };
}

fn classes() -> Vec<Class> {
    classes![
        Vehicle: "_Vehicle",
        AdaptParams: "_Params",
        MonitorParams: "_Params",
        PopParams: "_LawParams",
        PreviewPopParams: "_LawParams",
        PidParams: "_LawParams",
        PurePursuitParams: "_LawParams",
        StanleyParams: "_LawParams",
        CoupledLongitudinalParams: "_Params",
        SpeedPidParams: "_Params",
        SpeedTrackerParams: "_Params",
        DriverParams: "_Params",
        CarlaIdentified: "_CorePlant",
        KinematicBicycle: "_CorePlant",
        Noise: "_Params",
        Settings: "_Params",
    ]
}

/// A value as Python writes it.
fn python(value: Value) -> String {
    match value {
        Value::Absent => "None".into(),
        Value::Number(number) => format!("{number:?}"),
        Value::Count(count) => count.to_string(),
        Value::Flag(flag) => (if flag { "True" } else { "False" }).into(),
    }
}

/// The class in the stub.
fn stub((name, base, fields): &Class) -> Result<String, Box<dyn Error>> {
    let kind = |field: &Field| match field.default {
        Value::Count(_) => "int",
        Value::Flag(_) => "bool",
        _ if field.optional => "float | None",
        _ => "float",
    };
    let mut text = format!("\n@final\nclass {name}({base}):\n");
    let is_plant = *base == "_CorePlant";
    if is_plant {
        // A vehicle comes before the fields, which no field can say.
        text +=
            "    def __new__(\n        cls,\n        vehicle: Vehicle | None = None,\n        *,\n";
        for field in fields {
            let default = python(field.default);
            writeln!(text, "        {}: {} = {default},", field.name, kind(field))?;
        }
        text += "    ) -> Self: ...\n";
    }
    for field in fields {
        let (name, kind) = (field.name, kind(field));
        if is_plant {
            writeln!(text, "    {name}: Final[{kind}]")?;
        } else {
            writeln!(text, "    {name}: {kind} = {}", python(field.default))?;
        }
    }
    Ok(text)
}

/// The class's table on the page.
fn table((name, _, fields): &Class) -> Result<String, Box<dyn Error>> {
    let mut text =
        format!("\n## {name}\n\n| parameter | unit | default | range | |\n|---|---|---|---|---|\n");
    for field in fields {
        let default = match field.default {
            Value::Absent if field.written != "None" => field.formula().to_string(),
            value => python(value),
        };
        let range = field
            .requirement
            .map_or_else(String::new, |range| range.to_string());
        let what = field.text.replace('|', "\\|");
        let (name, unit) = (field.name, field.unit().unwrap_or_default());
        writeln!(text, "| `{name}` | {unit} | {default} | {range} | {what} |")?;
    }
    Ok(text)
}

/// Holds what a file has between two lines, or from the first to its end, to be `made`.
fn hold(file: &str, begin: &str, end: Option<&str>, made: &str) -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(file);
    let text = fs::read_to_string(&path)?;
    let (before, rest) = text.split_once(begin).ok_or("the mark is gone")?;
    let after = match end {
        Some(end) => rest.split_once(end).ok_or("the mark of the end is gone")?.1,
        None => "",
    };
    let wanted = [before, begin, made, end.unwrap_or_default(), after].concat();
    if env::var_os("POPSTEER_WRITE").is_some() {
        fs::write(&path, &wanted)?;
    }
    let is_made = fs::read_to_string(&path)? == wanted;
    assert!(
        is_made,
        "{file} is not that of the declarations: `make declared` writes it anew"
    );
    Ok(())
}

#[test]
fn test_stub_has_the_parameters_as_declared() -> Result<(), Box<dyn Error>> {
    let made: Result<String, _> = classes().iter().map(stub).collect();
    hold(
        "python/popsteer/_core.pyi",
        "# Parameters, as they are declared in Rust: `make declared` writes them.\n",
        Some("\n# End of the parameters.\n"),
        &made?,
    )
}

#[test]
fn test_page_has_the_parameters_as_declared() -> Result<(), Box<dyn Error>> {
    let made: Result<String, _> = classes().iter().map(table).collect();
    hold(
        "docs/parameters.md",
        "<!-- make declared writes what follows -->\n",
        None,
        &made?,
    )
}
