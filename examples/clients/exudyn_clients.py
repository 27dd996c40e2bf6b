"""EXUDYN: a ball that bounces on a plate, and a roller that comes down askew. Neither loses energy."""

from math import sqrt
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.utilities import *  # noqa: F403 (as EXUDYN's own examples do)

from contact_patch_c import Contact, Curve

here = Path(__file__).parent


def integrated(mbs, duration, steps):
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.show.computationTime = False
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)


def ball():
    mass, radius, modulus, v0 = 0.0327, 0.01, 1.1538461538461539e11, 0.5
    spring = Curve((here / "ball.json").read_text(), 1e-6)
    deepest = (15 / 16 * mass * v0**2 / (modulus * sqrt(radius))) ** 0.4
    duration = 2.9432750580 * deepest / v0
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    node = mbs.AddNode(Node1D(referenceCoordinates=[0.0], initialCoordinates=[0.0], initialVelocities=[v0]))
    mbs.AddObject(Mass1D(mass=mass, nodeNumber=node))
    ground = mbs.AddNode(NodePointGround())
    markers = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=0)) for n in [ground, node]]

    mbs.AddObject(CoordinateSpringDamperExt(markerNumbers=markers, springForceUserFunction=lambda mbs, t, item, depth, *rest: spring(depth)[0]))
    mbs.Assemble()
    integrated(mbs, 1.02 * duration, 4000)
    v = mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates_t)
    left = float(v if not hasattr(v, "__len__") else v[0])
    print(f"ball: restitution - 1 = {-left / v0 - 1:.1e}")
    assert abs(-left / v0 - 1) < 1e-6


def roller():
    """Depth and tilt of a roller that falls with one end ahead; the contact is solved at every step."""
    mass, inertia = 0.05, 0.05 * (0.02**2 / 12 + 0.01**2 / 4)
    contact = Contact((here / "roller.json").read_text())
    v0, tilt0 = 0.05, 2e-4
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    node = mbs.AddNode(NodeGenericODE2(referenceCoordinates=[0.0, 0.0], initialCoordinates=[-1e-7, tilt0], initialCoordinates_t=[v0, 0.0],
                                       numberOfODE2Coordinates=2))
    deepest, strongest = [0.0], [0.0]

    def forces(mbs, t, item, q, v):
        answer = contact(q[0], (q[1], 0.0))
        deepest[0], strongest[0] = max(deepest[0], q[0]), max(strongest[0], answer.force)
        # What works on the tilt is the integral of p x.
        return [-answer.force, answer.moment[1]]

    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag([mass, inertia]), forceUserFunction=forces))
    mbs.Assemble()
    integrated(mbs, 3.0e-4, 600)
    q = mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)
    v = mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates_t)
    assert contact(q[0], (q[1], 0.0)).force == 0.0, "it has left"
    before, after = 0.5 * mass * v0**2, 0.5 * mass * v[0] ** 2 + 0.5 * inertia * v[1] ** 2
    print(f"roller: energy after over before - 1 = {after / before - 1:.1e}; {0.5 * inertia * v[1]**2 / before:.1%} of it rocks; "
          f"to depth {deepest[0]:.2e}, force {strongest[0]:.1f}")
    assert abs(after / before - 1) < 4e-3 and inertia * v[1] ** 2 > 1e-3 * mass * v0**2


ball()
roller()
