#!/usr/bin/env python3
"""Writes docs/scene.md, every key of a scene, from the schema of the program.

    contact-patch schema | docs/scene.py            writes it
    contact-patch schema | docs/scene.py --check    exit code 1 when it is not what would be written
"""

import json
import sys
from pathlib import Path

FILE = Path(__file__).resolve().parent / "scene.md"

HEAD = """# Every key of a scene

Any consistent units; angles in degrees. An unknown key is an error that names it, its path and the nearest known one. The same as a JSON
Schema, for editors: `contact-patch schema`. One scene an idea: `data/scenes/`.
"""

TAIL = """
## Formulas

`{"kind": "formula", "expression": "x^2/2 + 0.1*abs(y)^3", "region": {"disc": 1.0}}`: in x, y, r = sqrt(x^2 + y^2) and theta = atan2(y, x), radians.

- Operators by falling precedence: `^` or `**` (from the right: 2^3^2 = 2^9; -x^2 = -(x^2)), sign, `*` `/`, `+` `-`. A product needs its `*`.
- Functions: abs, sign, sqrt, cbrt, exp, ln (also log), log10, log2, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, floor, ceil,
  atan2(y, x), hypot(a, b), pow(a, b), min and max of two or more.
- Constants: pi, e. Numbers: `2`, `0.5`, `.5`, `1e-3`.
- Where the value is not a finite number (the root of a negative number, a division by zero) there is no material.

## Files of measured bodies

Paths are relative to the scene file. NaN and empty nodes are holes.

| file | what is in it | needs |
|---|---|---|
| text grid (any other ending) | rows of heights, one row a y from the smallest on, separated by blanks, commas, semicolons or tabs; `#` begins a comment | `spacing` |
| XYZ (`.xyz`) | lines x y z on a regular grid, in any order | |
| NumPy (`.npy`) | a two-dimensional array, [j, i] at x_i, y_j | `spacing` |
| `.x3p` | ISO 25178-72, in metres | |
| `.sdf` | ISO 25178-71, ASCII, in metres | |
| profile, two columns | lines y z, separated by `,`, `;`, tab or blanks; comments | |
| profile, MiniProf (`.ban`, `.whl`) | header, then lines y z in millimetres | |

Written by `docs/scene.py` from `contact-patch schema`.
"""


def kind_of(value: dict, defs: dict) -> str:
    """A type in words; names of other tables as links."""
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[1]
        words = simple(defs[name], defs)
        return words or f"[{called(name)}](#{called(name)})"
    if "const" in value:
        return f"`{json.dumps(value['const'])}`"
    if "enum" in value:
        return ", ".join(f"`{json.dumps(one)}`" for one in value["enum"] if one is not None)
    for key in ("anyOf", "oneOf"):
        if key in value:
            found = [kind_of(one, defs) for one in value[key] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(filter(None, found)))
    types = value.get("type", [])
    types = [t for t in ([types] if isinstance(types, str) else types) if t != "null"]
    if "array" in types:
        inner = kind_of(value.get("items", {}), defs)
        if value.get("minItems") == value.get("maxItems") and value.get("minItems"):
            return "[" + ", ".join([inner] * value["minItems"]) + "]"
        return f"list of {inner}"
    return " or ".join(types)


def simple(definition: dict, defs: dict) -> str | None:
    """What a definition without keys of its own is, in words."""
    def keys(one: dict) -> bool:
        return "properties" in one or "$ref" in one and keys(defs[one["$ref"].rsplit("/", 1)[1]])
    if keys(definition) or any(keys(one) for one in definition.get("oneOf", []) + definition.get("anyOf", [])):
        return None
    return kind_of(definition, defs)


def called(name: str) -> str:
    words = name.removesuffix("Form")
    return "".join((" " if c.isupper() and k else "") + c.lower() for k, c in enumerate(words)).replace(" ", "-")


def rows(form: dict, defs: dict, passed_over=()) -> list[str]:
    lines = ["| key | value | |", "|---|---|---|"]
    for key, value in form["properties"].items():
        if key in passed_over:
            continue
        needed = "" if key in form.get("required", []) else " (optional)"
        said = " ".join(value.get("description", "").split()).replace("|", "\\|")
        lines.append(f"| `{key}`{needed} | {kind_of(value, defs).replace('|', chr(92) + '|')} | {said} |")
    return lines if len(lines) > 2 else []


def text(schema: dict) -> str:
    defs = schema["$defs"]
    lines = [HEAD, "## The scene", ""] + rows(schema, defs, ["$schema"])
    for name, form in defs.items():
        if name == "GapForm" or simple(form, defs) is not None:
            continue
        lines += ["", f"## {called(name)}", "", " ".join(form.get("description", "").split())]
        if "properties" in form:
            lines += [""] + rows(form, defs)
        for one in form.get("oneOf", []) + form.get("anyOf", []):
            said = " ".join(one.get("description", "").split())
            if "properties" in one:
                lines += [""] + ([said, ""] if said else []) + rows(one, defs)
            else:
                lines += ["", f"- {kind_of(one, defs)} {said}"]
    lines += ["", "## gap", "", "Every kind takes `at: [x, y]`, where its origin stands, and `rotate`, degrees counter-clockwise about `at`."]
    for one in defs["GapForm"]["oneOf"]:
        lines += ["", f"### {one['properties']['kind']['const']}", "", " ".join(one.get("description", "").split()), ""]
        lines += rows(one, defs, ["kind", "at", "rotate"])
    return "\n".join(lines).rstrip() + "\n" + TAIL


def main() -> int:
    written = text(json.load(sys.stdin))
    if sys.argv[1:] == ["--check"]:
        if not FILE.exists() or FILE.read_text(encoding="utf-8") != written:
            print("docs/scene.md is not that of the schema: contact-patch schema | docs/scene.py")
            return 1
        return 0
    FILE.write_text(written, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
