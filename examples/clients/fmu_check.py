"""The functional mock-up unit by fmpy: valid, simulated both ways against the library, directional derivatives by differences."""

import math
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

from contact_patch_c import Curve

unit, scene = sys.argv[1:]
curve = Curve(Path(scene).read_text(), 1e-4)

problems = validate_fmu(unit)
assert not problems, problems
print("fmpy: no problems found")

deepest = 5e-5
time = np.linspace(0, 1, 201)
# In and out, beyond the range, with its velocity.
depth = deepest * 1.2 * np.sin(2 * math.pi * time)
velocity = deepest * 1.2 * 2 * math.pi * np.cos(2 * math.pi * time)
given = np.rec.fromarrays([time, depth, velocity], names=["time", "depth", "velocity"])
for kind in ["CoSimulation", "ModelExchange"]:
    found = simulate_fmu(unit, fmi_type=kind, input=given, output=["depth", "force", "stiffness", "area"], start_time=0, stop_time=1,
                         step_size=0.005, output_interval=0.005)
    missed = 0.0
    for row in found:
        force, stiffness = curve(row["depth"])
        scale = curve(deepest)
        missed = max(missed, abs(row["force"] - force) / scale[0], abs(row["stiffness"] - stiffness) / scale[1])
    assert len(found) > 150 and max(found["force"]) > 0 and min(found["force"]) == 0, kind
    assert missed < 1e-12, (kind, missed)
    print(f"{kind}: {len(found)} rows, {missed:.1e} from the library")

# Directional derivatives, states, what is refused.
description = read_model_description(unit)
at = {v.name: v.valueReference for v in description.modelVariables}
with tempfile.TemporaryDirectory() as folder:
    extract(unit, folder)
    def new(name):
        model = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
        model.instantiate()
        model.setupExperiment(startTime=0.0)
        model.enterInitializationMode()
        model.exitInitializationMode()
        return model
    one, other = new("one"), new("other")
    names = ["depth", "velocity", "damping"]
    place = {"depth": 2e-5, "velocity": -0.1, "damping": 0.4}
    def outputs(model, place):
        model.setReal([at[n] for n in names], [place[n] for n in names])
        return np.array(model.getReal([at[n] for n in ["force", "stiffness", "area"]]))
    other_before = outputs(other, {"depth": 1e-5, "velocity": 0.0, "damping": 0.0})
    here = outputs(one, place)
    force = curve(2e-5)[0]
    assert abs(here[0] / (force * (1 + 0.4 * -0.1)) - 1) < 1e-12, "Hunt and Crossley"
    for name in names:
        e = 1e-6 * abs(place[name])
        low, high = (outputs(one, {**place, name: place[name] + by}) for by in [-e, e])
        outputs(one, place)
        slope = one.getDirectionalDerivative([at[n] for n in ["force", "stiffness", "area"]], [at[name]], [1.0])
        for k, by_difference in enumerate((high - low) / (2 * e)):
            unit_of = abs(here[k]) / abs(place[name])
            assert abs(slope[k] - by_difference) < 1e-5 * unit_of, (name, k, slope[k], by_difference)
    kept = one.getFMUState()
    outputs(one, {"depth": 4e-5, "velocity": 0.0, "damping": 0.0})
    one.setFMUState(kept)
    assert np.array_equal(one.getReal([at["force"]]), here[:1])
    one.freeFMUState(kept)
    # Two of them do not know of each other; a fast retreat never pulls.
    assert np.array_equal(np.array(other.getReal([at["force"]])), other_before[:1])
    assert outputs(one, {"depth": 2e-5, "velocity": -10.0, "damping": 1.0})[0] == 0.0
    for model in [one, other]:
        model.terminate()
        model.freeInstance()
print("directional derivatives, kept states, damping: as they should be")
