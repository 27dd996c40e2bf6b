#!/usr/bin/env bash
# Everything that must hold of the Python package: built as its users build it, into an environment of its own. Needs Python 3.10 or
# later, and Java for the test on Spark, which is passed over without.
set -euo pipefail
cd "$(dirname "$0")"

# The package carries the licence of the crate.
cmp LICENSE ../LICENSE

venv=${CARGO_TARGET_DIR:-../target}/python
python3 -m venv "$venv"
venv=$(cd "$venv" && pwd)

"$venv/bin/pip" install --quiet --disable-pip-version-check '.[test]'

# What is written of the types holds, of the compiled part as of the rest.
"$venv/bin/mypy" --config-file pyproject.toml
"$venv/bin/python" -m mypy.stubtest contact_patch._core --mypy-config-file pyproject.toml
"$venv/bin/python" -m pytest --doctest-modules --pyargs contact_patch -p no:cacheprovider
"$venv/bin/python" -m pytest tests -p no:cacheprovider
