#!/usr/bin/env python3
"""Writes rail.ban and wheel.whl: what a MiniProf would have measured, in mm, with 2 um of noise along the normal.

The rail's head is drawn by arcs of 300, 80 and 13 mm that touch one another; the wheel by a tread of 1 in 20, a root fillet of 14 mm and a
flange of 70 degrees. y to the gauge side, z upwards, y = 0 on the middle of the head and on the tape circle.
    python3 make_profiles.py          in this directory
"""
import math, random


def arc(start, slope, to_slope, radius):
    """Points from `start` on a curve whose angle goes from `slope` to `to_slope`; radius > 0."""
    n = max(2, round(abs(to_slope - slope) * radius / 0.25))
    (y, z), side = start, math.copysign(1.0, to_slope - slope)
    for k in range(1, n + 1):
        a = slope + (to_slope - slope) * k / n
        yield [y + side * radius * (math.sin(a) - math.sin(slope)), z - side * radius * (math.cos(a) - math.cos(slope)), a]


def rail():
    half = [[0.0, 0.0, 0.0]]
    for (y0, y1), radius in zip([(0.0, 10.26), (10.26, 25.35)], [300.0, 80.0]):
        y, z, a = half[-1]
        half += arc((y, z), a, math.asin(math.sin(a) - (y1 - y0) / radius), radius)
    y, z, a = half[-1]
    half += arc((y, z), a, -1.3, 13.0)
    return [[-y, z, -a] for y, z, a in reversed(half[1:])] + half


def wheel():
    tread = math.atan(1 / 20)
    line = [[y, -y / 20, -tread] for y in (0.25 * k - 50 for k in range(301))]
    y, z, a = line[-1]
    return line + list(arc((y, z), a, -math.radians(70), 14.0))


def write(name, line, seed, sort):
    noise = random.Random(seed)
    with open(name, "w") as file:
        file.write(f"ProfileType={sort}\nUnits=mm\nXYPoints={len(line)}\nColumnDef=X,Y\n\n")
        for y, z, a in line:
            off = noise.gauss(0.0, 0.002)
            file.write(f"{y - off * math.sin(a):.4f}\t{z + off * math.cos(a):.4f}\n")


write("rail.ban", rail(), 1, "Rail")
write("wheel.whl", wheel(), 2, "Wheel")

# A flank whose radius grows along it from 20 to 60 mm, as a spreadsheet writes it where decimals have commas.
with open("flank.csv", "w") as file:
    file.write("y [mm];z [mm]\n")
    for k in range(81):
        y = 0.1 * k - 4.0
        z = y * y / 80 - y**3 / 1600
        file.write(f"{y:.1f};{z:.6f}\n".replace(".", ","))
