#!/usr/bin/env python3
"""Writes docs/methods.md: error against run time of every method, from `contact-patch compare` over shipped scenes.

    docs/methods.py PROGRAM     runs it (two minutes) and writes the page

Times are those of the machine it runs on; the page says so. Nothing else in it depends on the machine.
"""

import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCENES = HERE.parent / "data" / "scenes"

CHOSEN = {
    "tetrahedral_punch": "A tip of three faces: the punch of Barber & Billings (1990). The exact pressure is infinite at the tip.",
    "four_faced_punch": "Four faces, where `fabrikant` has a maximum inside its admissible range.",
    "elliptic_paraboloid": "Hertz: the closed form is the reference, so that all other methods can be read against it.",
    "flat_square": "Sharp edges: `auto` takes cells graded to the edges; a uniform grid is a staircase there.",
    "truncated_pyramid": "A flat with flanks (a worn tip), pressed past its flat.",
    "two_tips": "Two contacts, one feeling the other: not star-shaped, so that `fabrikant` refuses.",
    "revolved_tip": "A body of revolution given by points.",
    "formula_superellipse": "A smooth gap without a law, as text.",
    "wheel_on_rail": "Measured profiles with 2 um of noise, smoothed: what the samples leave open limits every method.",
}

HEAD = """# Error against run time, method by method

`contact-patch compare SCENE` on shipped scenes, one thread, medians of three runs; written by `docs/methods.py`. The error is that of the
force against the reference of each table, the estimate what the method states of itself, `-` where it states none. A time is CPU seconds
of one solve on the machine that wrote the page (a shared core of about 2.5 GHz); ratios within a table are what to read.

- `ritz` is a lower bound and costs microseconds; `fabrikant` is closer on tips and states no error: an estimate for inner loops.
- `qp` (Clarabel) solves the same cells as `fft` to the same digits at ten to a hundred times the cost: the reference, not the way to work.
- `fft` halves its error by four with each doubling on smooth gaps, by two at sharp edges.
- `auto` picks: a closed form, fitted cells, or grids until the stated error is below the tolerance.
"""


def row(run: dict) -> str:
    at = f"{run['cells']} cells" if run.get("cells") else (f"tolerance {run['tolerance']:.0e}" if run.get("tolerance") else "")
    ran = f" ({run['ran']})" if run.get("ran") and run["ran"] != run["method"] else ""
    if run.get("force") is None:
        return f"| `{run['method']}` | {at} | {run['verdict'].replace('_', ' ')} | | |"
    error = "reference" if run.get("error") in (0, None) else f"{run['error']:+.1e}"
    estimate = f"{run['estimate']:.1e}" if run.get("estimate") is not None else "-"
    return f"| `{run['method']}`{ran} | {at} | {error} | {estimate} | {seconds(run['seconds'])} |"


def seconds(s: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if s >= size:
            return f"{s / size:.{0 if s >= 10 * size else 1}f} {unit}"
    return "below 1 us"


def main() -> None:
    program = sys.argv[1]
    parts = [HEAD]
    for name, about in CHOSEN.items():
        done = subprocess.run([program, "compare", SCENES / f"{name}.json", "-o", "-"], capture_output=True, text=True)
        if done.returncode not in (0, 1) or not done.stdout:
            sys.exit(f"{name}: {done.stderr}")
        found = json.loads(done.stdout)
        reference = found["reference"]
        parts.append(f"\n## {name.replace('_', ' ')}\n\n{about}\n")
        known = f"{reference['uncertainty']:.1e}" if reference.get("uncertainty") is not None else "not known"
        parts.append(f"Reference: {reference['source']}; force {reference['force']:.6g}, relative error {known}.\n")
        parts.append("| method | at | error of the force | estimate | time |\n|---|---|---|---|---|")
        parts.extend(row(run) for run in found["runs"])
    (HERE / "methods.md").write_text("\n".join(parts) + "\n")


if __name__ == "__main__":
    main()
