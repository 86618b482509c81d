//! Names the shared library by the version of its ABI.

use std::env;

/// `POPSTEER_ABI_VERSION`; a test holds the two together.
const ABI: &str = "2";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    match env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux" | "android" | "freebsd") => {
            println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libpopsteer.so.{ABI}");
        }
        Ok("macos") => {
            let name = format!("@rpath/libpopsteer.{ABI}.dylib");
            println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,{name}");
        }
        _ => {}
    }
}
