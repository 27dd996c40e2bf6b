"""A ball bounces on a plate, by SciPy's integrators over the C interface."""

from math import sqrt
from pathlib import Path

from scipy.integrate import solve_ivp

from contact_patch_c import Curve

MASS, RADIUS, MODULUS, V0 = 0.0327, 0.01, 1.1538461538461539e11, 0.5

ball = Curve(Path(__file__).with_name("ball.json").read_text(), 1e-6)
deepest = (15 / 16 * MASS * V0**2 / (MODULUS * sqrt(RADIUS))) ** 0.4
duration = 2.9432750580 * deepest / V0


def leaves(_, y):
    return y[0]


leaves.terminal, leaves.direction = True, -1
for method in ["DOP853", "Radau"]:
    def slope(_, y):
        return [y[1], -ball(y[0])[0] / MASS]

    def jacobian(_, y):
        return [[0.0, 1.0], [-ball(y[0])[1] / MASS, 0.0]]

    more = {"jac": jacobian} if method == "Radau" else {}
    found = solve_ivp(slope, [0, 2 * duration], [0.0, V0], method=method, rtol=1e-9, atol=1e-16, events=leaves, max_step=duration / 50, **more)
    restitution = -found.y[1, -1] / V0
    largest = max(found.y[0])
    lasted = found.t[-1] / duration
    print(f"{method:7} restitution - 1 {restitution - 1:9.1e}, duration over Hertz {lasted - 1:9.1e}, {found.nfev} evaluations")
    assert abs(restitution - 1) < 1e-6 and abs(lasted - 1) < 1e-5 and largest <= deepest * (1 + 1e-6)
