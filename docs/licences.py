#!/usr/bin/env python3
"""Writes docs/licences.md: the licences of all crates that the program is built from, by `cargo metadata`.

    docs/licences.py            writes it
    docs/licences.py --check    exit code 1 when it is not what would be written
"""

import json
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

HERE = Path(__file__).resolve().parent


def text() -> str:
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", "x86_64-unknown-linux-gnu"]
    metadata = json.loads(subprocess.run(command, cwd=HERE.parent, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = next(id for id, package in packages.items() if package["name"] == "contact-patch")
    # What is linked: normal dependencies, not those of tests or builds.
    found, waiting = set(), [root]
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if linked and dependency["pkg"] not in found:
                found.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    by_licence = defaultdict(list)
    for id in found:
        package = packages[id]
        by_licence[(package["license"] or "see the crate").replace("/", " OR ")].append(package["name"])
    lines = [
        "# Licences",
        "",
        "`contact-patch` itself: MIT (`LICENSE`). The font of pictures in pixels (`data/fonts/`): `data/fonts/LICENSE.txt`. The crates that "
        "the program is linked with, all features, on Linux:",
        "",
        "| licence | crates |",
        "|---|---|",
    ]
    lines += [f"| {licence} | {', '.join(sorted(set(names)))} |" for licence, names in sorted(by_licence.items())]
    lines += ["", "Written by `docs/licences.py` from `cargo metadata`.", ""]
    return "\n".join(lines)


def main() -> int:
    file = HERE / "licences.md"
    if sys.argv[1:] == ["--check"]:
        if file.read_text(encoding="utf-8") != text():
            print("docs/licences.md is not that of Cargo.lock: run docs/licences.py")
            return 1
        return 0
    file.write_text(text(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
