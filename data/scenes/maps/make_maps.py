#!/usr/bin/env python3
"""Makes the height maps that the scenes beside this folder use. Needs NumPy; run it in this folder."""

import numpy as np


def rough(nodes, spacing, hurst, rms, seed):
    """A self-affine rough surface: power spectrum ~ |q|^(-2 - 2 hurst), random phases, given rms height."""
    random = np.random.default_rng(seed)
    q = 2 * np.pi * np.fft.fftfreq(nodes, spacing)
    qx, qy = np.meshgrid(q, q)
    magnitude = np.hypot(qx, qy)
    magnitude[0, 0] = np.inf
    shortest = np.pi / (4 * spacing)
    amplitude = np.where(magnitude < shortest, magnitude ** (-1 - hurst), 0)
    phase = random.uniform(0, 2 * np.pi, (nodes, nodes))
    height = np.fft.ifft2(amplitude * np.exp(1j * phase)).real
    return height * rms / height.std()


def grid(nodes, spacing):
    line = (np.arange(nodes) - (nodes - 1) / 2) * spacing
    return np.meshgrid(line, line)


# A lapped surface on the lower body, peaks up; metres, 4-byte floats.
np.save("rough.npy", rough(65, 1e-6, 0.8, 5e-9, 1).astype(np.float32))

# A ball of radius 10 mm on the upper body, in micrometres; dust has left holes.
x, y = grid(49, 2e-6)
ball = (x**2 + y**2) / (2 * 1e-2) * 1e6
ball[(x - 2.0e-5) ** 2 + (y - 1.0e-5) ** 2 < (6e-6) ** 2] = np.nan
ball[(x + 2.4e-5) ** 2 + (y + 1.6e-5) ** 2 < (4e-6) ** 2] = np.nan
with open("ball_with_holes.txt", "w") as out:
    out.write("# heights of the upper surface in micrometres, 49 x 49 nodes, 2 um apart\n")
    for row in ball:
        out.write(" ".join("nan" if np.isnan(z) else f"{z:.6f}" for z in row) + "\n")

# A ball of radius 10 mm, on a stage that was not level; x y z in metres, in no order.
x, y = grid(33, 3e-6)
tilted = (x**2 + y**2) / (2 * 1e-2) + 2e-4 * x - 1e-4 * y
points = np.column_stack([x.ravel(), y.ravel(), tilted.ravel()])
np.random.default_rng(2).shuffle(points)
np.savetxt("tilted_ball.xyz", points, fmt="%.6e", header="x y z in metres")

# A ball and the worn track it runs in.
x, y = grid(49, 2e-6)
np.save("ball.npy", (x**2 + y**2) / (2 * 1e-2))
np.save("track.npy", y**2 / (2 * 2e-2) + 1e-9 * np.cos(2 * np.pi * x / 16e-6))
