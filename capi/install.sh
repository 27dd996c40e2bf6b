#!/usr/bin/env bash
# Builds the C interface and puts header, libraries, CMake and pkg-config files below a directory: capi/install.sh PREFIX
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: capi/install.sh PREFIX" >&2; exit 2; }
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
cd "$(dirname "$0")"

cargo build --release --package contact-patch-c
built=${CARGO_TARGET_DIR:-../target}/release
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
# What the static library links to, as the compiler says.
private="-lpthread -ldl -lm"

install -d "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/contact_patch"
install -m 644 include/contact_patch.h "$prefix/include/"
for library in libcontact_patch_c.so libcontact_patch_c.dylib libcontact_patch_c.a; do
    [ ! -e "$built/$library" ] || install -m 755 "$built/$library" "$prefix/lib/"
done
sed -e "s|@PREFIX@|$prefix|" -e "s|@VERSION@|$version|" -e "s|@PRIVATE@|$private|" contact_patch.pc.in > "$prefix/lib/pkgconfig/contact_patch.pc"
sed -e "s|@VERSION@|$version|" -e "s|@LIBRARIES@|pthread;dl;m|" cmake/contact_patch-config.cmake > "$prefix/lib/cmake/contact_patch/contact_patch-config.cmake"
sed -e "s|@VERSION@|$version|" cmake/contact_patch-config-version.cmake > "$prefix/lib/cmake/contact_patch/contact_patch-config-version.cmake"
