//! `include/popsteer.h` is what cbindgen makes of the source, and says the version that the
//! library is named by.
//!
//! After a change of the interface: `POPSTEER_WRITE_HEADER=1 cargo test -p popsteer-c`.

use std::error::Error;
use std::path::Path;
use std::{env, fs};

fn made(folder: &Path) -> Result<String, Box<dyn Error>> {
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml"))?;
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_crate(folder)
        .generate()?;
    let mut header = Vec::new();
    bindings.write(&mut header);
    // What Rust's pages head so are the duties of who calls.
    Ok(String::from_utf8(header)?.replace("* # Safety\n", "* Required of the caller:\n"))
}

#[test]
fn test_header_is_that_of_the_source() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let committed = folder.join("include/popsteer.h");
    let made = made(folder)?;
    if env::var_os("POPSTEER_WRITE_HEADER").is_some() {
        fs::write(&committed, &made)?;
    }
    let committed = fs::read_to_string(committed)?;
    let difference = made
        .lines()
        .zip(committed.lines())
        .find(|(made, committed)| made != committed);
    assert!(
        made == committed,
        "popsteer.h is not that of the source (POPSTEER_WRITE_HEADER=1 writes it anew): {difference:?}"
    );
    Ok(())
}

#[test]
fn test_library_is_named_by_the_version_of_its_header() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = fs::read_to_string(folder.join("include/popsteer.h"))?;
    let build = fs::read_to_string(folder.join("build.rs"))?;
    let version = header
        .lines()
        .find_map(|line| line.strip_prefix("#define POPSTEER_ABI_VERSION "))
        .ok_or("no version in the header")?;
    assert!(build.contains(&format!("const ABI: &str = \"{version}\";")));
    Ok(())
}
