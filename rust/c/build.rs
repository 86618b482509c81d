//! Names the shared library by the version of its ABI, `POPSTEER_ABI_VERSION` in `src/lib.rs`.

use std::env;

const SOURCE: &str = include_str!("src/lib.rs");

fn main() -> Result<(), &'static str> {
    println!("cargo::rerun-if-changed=src/lib.rs");
    let (_, rest) = SOURCE
        .split_once("POPSTEER_ABI_VERSION: u32 = ")
        .ok_or("src/lib.rs has no POPSTEER_ABI_VERSION")?;
    let (abi, _) = rest
        .split_once(';')
        .ok_or("POPSTEER_ABI_VERSION has no end")?;
    match env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux" | "android" | "freebsd") => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libpopsteer.so.{abi}");
        }
        Ok("macos") => {
            let name = format!("@rpath/libpopsteer.{abi}.dylib");
            println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,{name}");
        }
        _ => {}
    }
    Ok(())
}
