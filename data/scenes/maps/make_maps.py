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


def x3p(name, height, spacing):
    """A surface as ISO 25178-72 has it: a zip archive of main.xml and little-endian doubles, NaN for holes."""
    import hashlib
    import zipfile

    data = np.asarray(height, "<f8").tobytes()
    axis = "<C{0}><AxisType>{1}</AxisType><DataType>D</DataType><Increment>{2!r}</Increment><Offset>0</Offset></C{0}>"
    axes = axis.format("X", "I", spacing) + axis.format("Y", "I", spacing) + axis.format("Z", "A", 1)
    ny, nx = height.shape
    xml = f"""<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
<Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1>
<Record2><Date>2020-01-01T00:00:00Z</Date><Instrument><Manufacturer>none</Manufacturer><Model>none</Model><Serial>0</Serial><Version>0</Version></Instrument>
<CalibrationDate>2020-01-01T00:00:00Z</CalibrationDate><ProbingSystem><Type>Software</Type><Identification>none</Identification></ProbingSystem></Record2>
<Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ></MatrixDimension><DataLink>
<PointDataLink>bindata/data.bin</PointDataLink><MD5ChecksumPointData>{hashlib.md5(data).hexdigest()}</MD5ChecksumPointData></DataLink></Record3>
<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
"""
    with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as out:
        out.writestr("main.xml", xml)
        out.writestr("bindata/data.bin", data)
        out.writestr("md5checksum.hex", hashlib.md5(xml.encode()).hexdigest() + " *main.xml\n")


# A ball of radius 5 mm, seen by a profiler every 4 um with 5 nm of noise and a speck that it could not see; metres.
x, y = grid(61, 4e-6)
noisy = (x**2 + y**2) / (2 * 5e-3) + 5e-9 * np.random.default_rng(3).standard_normal(x.shape)
noisy[(x - 6e-5) ** 2 + (y - 6e-5) ** 2 < (9e-6) ** 2] = np.nan
x3p("noisy_ball.x3p", noisy, 4e-6)

# A ball of radius 5 mm every 4 um, heights in whole nanometres, as an ASCII surface data file of ISO 25178-71.
with open("ball.sdf", "w") as out:
    out.write("aISO-1.0\nManufacID   = none\nCreateDate  = 010120200000\nModDate     = 010120200000\n")
    out.write("NumPoints   = 61\nNumProfiles = 61\nXscale      = 4e-06\nYscale      = 4e-06\nZscale      = 1e-10\n")
    out.write("Zresolution = -1\nCompression = 0\nDataType    = 6\nCheckType   = 0\n*\n")
    for row in np.round((x**2 + y**2) / (2 * 5e-3) / 1e-10).astype(int):
        out.write(" ".join(str(z) for z in row) + "\n")
    out.write("*\n*\n")
