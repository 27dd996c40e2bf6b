#!/usr/bin/env bash
# The contact as a spring in other people's programs: a plain C program, SciPy, fmpy, EXUDYN. Needs a C compiler and Python 3.
set -euo pipefail
cd "$(dirname "$0")"
target=${CARGO_TARGET_DIR:-../../target}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

../../capi/install.sh "$work/prefix"
cargo build --release --quiet
program=$(cd "$target/release" && pwd)/contact-patch

"$program" curve ball.json --accuracy 1e-6 --format c --name ball -o "$work/ball_spring.h"
cc -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -I"$work" bounce.c -o "$work/bounce" -lm
"$work/bounce"

python3 -m venv "$target/clients"
"$target/clients/bin/pip" install --quiet --disable-pip-version-check fmpy scipy exudyn
for library in "$work"/prefix/lib/libcontact_patch_c.{so,dylib}; do
    [ ! -e "$library" ] || export CONTACT_PATCH_LIBRARY=$library
done
python=$target/clients/bin/python
"$python" scipy_bounce.py
"$program" curve ball.json --accuracy 1e-4 --format fmu --name ball -o "$work/ball.fmu"
"$python" fmu_check.py "$work/ball.fmu" ball.json
"$python" exudyn_clients.py
