#!/bin/sh
# Installs the C interface, built by `cargo build --release --package popsteer-c`, under a prefix.
set -eu

prefix=$1
here=$(cd "$(dirname "$0")" && pwd)
built=${CARGO_TARGET_DIR:-$here/../../target}/release
version=$(sed -n '/^\[workspace\.package\]/,/^$/s/^version = "\(.*\)"$/\1/p' "$here/../../Cargo.toml")
abi=$(sed -n 's/^#define POPSTEER_ABI_VERSION //p' "$here/include/popsteer.h")

case $(uname -s) in
Darwin)
    library=libpopsteer.dylib
    shared=libpopsteer.$abi.dylib
    system="-lm"
    ;;
*)
    library=libpopsteer.so
    shared=libpopsteer.so.$abi
    system="-lgcc_s -lpthread -ldl -lm -lc"
    ;;
esac

fill() {
    sed -e "s|@VERSION@|$version|" -e "s|@SHARED@|$shared|" -e "s|@SYSTEM_LIBS@|$system|" "$1"
}

mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/popsteer"
install -m 644 "$here/include/popsteer.h" "$here/include/popsteer.hpp" "$prefix/include/"
install -m 644 "$built/libpopsteer.a" "$prefix/lib/"
install -m 755 "$built/$library" "$prefix/lib/$shared"
ln -sf "$shared" "$prefix/lib/$library"
fill "$here/popsteer.pc.in" >"$prefix/lib/pkgconfig/popsteer.pc"
for file in popsteer-config.cmake popsteer-config-version.cmake; do
    fill "$here/cmake/$file.in" >"$prefix/lib/cmake/popsteer/$file"
done
echo "popsteer $version for C and C++ is in $prefix: include, lib, lib/pkgconfig, lib/cmake"
