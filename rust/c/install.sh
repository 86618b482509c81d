#!/bin/sh
# Installs the C interface, built by `cargo build --release --package popsteer-c`, under a prefix, or
# removes it from there: install.sh PREFIX [LIBDIR [uninstall]], LIBDIR from the prefix on.
set -eu

prefix=$1
libdir=${2:-lib}
lib=$prefix/$libdir
# From the files in folders of LIBDIR back to the prefix.
up=$(printf '%s\n' "$libdir" | sed 's|[^/][^/]*|..|g')
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

if [ "${3:-}" = uninstall ]; then
    rm -f "$prefix/include/popsteer.h" "$prefix/include/popsteer.hpp" "$lib/libpopsteer.a" \
        "$lib/$library" "$lib/$shared" "$lib/pkgconfig/popsteer.pc" \
        "$lib/cmake/popsteer/popsteer-config.cmake" \
        "$lib/cmake/popsteer/popsteer-config-version.cmake"
    rmdir "$lib/cmake/popsteer" 2>/dev/null || true
    echo "popsteer for C and C++ is no longer in $prefix"
    exit
fi

fill() {
    sed -e "s|@LIBDIR@|$libdir|" -e "s|@UP@|$up|" -e "s|@VERSION@|$version|" -e "s|@SHARED@|$shared|" -e "s|@SYSTEM_LIBS@|$system|" "$1"
}

mkdir -p "$prefix/include" "$lib/pkgconfig" "$lib/cmake/popsteer"
install -m 644 "$here/include/popsteer.h" "$here/include/popsteer.hpp" "$prefix/include/"
install -m 644 "$built/libpopsteer.a" "$lib/"
install -m 755 "$built/$library" "$lib/$shared"
ln -sf "$shared" "$lib/$library"
fill "$here/popsteer.pc.in" >"$lib/pkgconfig/popsteer.pc"
for file in popsteer-config.cmake popsteer-config-version.cmake; do
    fill "$here/cmake/$file.in" >"$lib/cmake/popsteer/$file"
done
echo "popsteer $version for C and C++ is in $prefix: include, $libdir, $libdir/pkgconfig, $libdir/cmake"
