//! Hands the linker the memory of the board, where there is a board.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=link.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
        println!("cargo::rustc-link-arg-bins=-T{folder}/link.x");
    }
}
