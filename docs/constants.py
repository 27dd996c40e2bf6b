#!/usr/bin/env python3
"""Holds docs/constants.md against the sources.

    docs/constants.py           prints the constants of the covered folders that the page does not name
    docs/constants.py --check   the same, and exits with 1 if there are any, or if a value differs
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCES = HERE.parent / "src"
# Of other folders only what decides an error stands on the page.
COVERED = ["acceptance", "bracket", "check", "consistency", "energy", "grid_method"]
CONSTANT = re.compile(r"^\s*(?:pub(?:\([a-z:]*\))? )?const ([A-Z][A-Z0-9_]*): ([^=]+?)\s*=\s*(.*?);", re.M | re.S)
NUMBERS = re.compile(r"f64|usize|u\d\d|i\d\d|Left|Range")


def constants(path):
    """Numbers that stand in a file before its tests, by name."""
    text = path.read_text().split("#[cfg(test)]")[0]
    squeezed = ((name, kind, re.sub(r"\s+", " ", value).replace("[ ", "[").replace(", ]", "]").replace(" ]", "]")) for name, kind, value in CONSTANT.findall(text))
    return {name: value for name, kind, value in squeezed if NUMBERS.search(kind)}


def main():
    page = (HERE / "constants.md").read_text()
    rows = re.findall(r"^\| `([a-z_/]+)` \| `([A-Z0-9_]+)` \| `(.*?)` \|", page, re.M)
    only_cost = {folder: set(re.findall(r"`([A-Z0-9_]+)`", names)) for folder, names in re.findall(r"^\| `([a-z_]+)/` \| (.*) \|$", page, re.M)}
    faults = []
    for file, name, value in rows:
        path = SOURCES / f"{file}.rs"
        found = constants(path).get(name) if path.exists() else None
        if found != value:
            faults.append(f"{file}: {name} is {found or 'not there'}, the page has {value}")
    told = {(file, name) for file, name, _ in rows}
    for folder in COVERED:
        for path in sorted((SOURCES / folder).rglob("*.rs")):
            file = str(path.relative_to(SOURCES).with_suffix(""))
            for name in constants(path):
                if (file, name) not in told and name not in only_cost.get(folder, ()):
                    faults.append(f"{file}: {name} is not on the page")
    print(*faults, sep="\n")
    sys.exit(bool(faults) and "--check" in sys.argv)


if __name__ == "__main__":
    main()
