#!/usr/bin/env bash
# Everything that must hold of the C interface: installed as its users install it, then a C program against the shared and the static
# library, from two threads, as C and as C++. With valgrind where there is one (VALGRIND=no leaves it out).
set -euo pipefail
cd "$(dirname "$0")"
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
./install.sh "$prefix"

warnings=(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Werror)
cc -std=c99 "${warnings[@]}" -I"$prefix/include" tests/interface.c -o "$prefix/shared" -L"$prefix/lib" -lcontact_patch_c -Wl,-rpath,"$prefix/lib" -lpthread -lm
cc -std=c99 "${warnings[@]}" -I"$prefix/include" tests/interface.c -o "$prefix/static" "$prefix/lib/libcontact_patch_c.a" -lpthread -ldl -lm
"$prefix/shared"
"$prefix/static"

# The header by itself, as C89 and C++.
echo '#include <contact_patch.h>' > "$prefix/header.c"
cc -std=c89 -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" -fsyntax-only "$prefix/header.c"
cp "$prefix/header.c" "$prefix/header.cpp"
c++ -std=c++98 -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" -fsyntax-only "$prefix/header.cpp"

if command -v pkg-config > /dev/null; then
    PKG_CONFIG_PATH=$prefix/lib/pkgconfig pkg-config --cflags --libs contact_patch
fi
if command -v cmake > /dev/null; then
    mkdir "$prefix/cmake"
    cp tests/interface.c "$prefix/cmake/"
    cat > "$prefix/cmake/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.10)
project(client C)
find_package(contact_patch REQUIRED)
find_package(Threads REQUIRED)
add_executable(client interface.c)
target_link_libraries(client contact_patch::contact_patch Threads::Threads m)
CMAKE
    cmake -S "$prefix/cmake" -B "$prefix/cmake/build" -DCMAKE_PREFIX_PATH="$prefix" > /dev/null
    cmake --build "$prefix/cmake/build" > /dev/null
    LD_LIBRARY_PATH=$prefix/lib "$prefix/cmake/build/client"
fi
if [ "${VALGRIND:-yes}" = yes ] && command -v valgrind > /dev/null; then
    valgrind --quiet --error-exitcode=3 --leak-check=full --errors-for-leak-kinds=definite "$prefix/shared"
fi
