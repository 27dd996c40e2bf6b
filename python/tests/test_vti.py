"""Fields as ParaView reads them."""

import numpy as np
import pytest

from contact_patch import Contact, Unsolved, gap

vtk = pytest.importorskip("vtk")


def read(path):
    """Cell data by name, and the grid, as VTK's own reader has them."""
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    data = image.GetCellData()
    arrays = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
    return image, arrays


@pytest.fixture(scope="module")
def solution():
    of = gap.Formula("x^2/2 + abs(y)^3 + 0.3*y", ellipse=[1.5, 0.4]).placed(at=[1e-3, 0.5])
    return Contact(of, modulus=1.0, depth=0.5, method="fft", cells=40, tolerance=0.5, outputs=["pressure", "gap"]).solve()


def test_every_number_is_read_back(solution, tmp_path):
    path = tmp_path / "field.vti"
    assert solution.to_vti(path) == path.read_bytes()
    image, arrays = read(path)
    ny, nx = solution.pressure.values.shape
    assert image.GetDimensions() == (nx + 1, ny + 1, 1)
    left, right, bottom, top = solution.pressure.extent
    assert image.GetBounds() == pytest.approx((left, right, bottom, top, 0.0, 0.0))
    assert np.array_equal(arrays["pressure"].reshape(ny, nx), solution.pressure.values)
    wanted = np.where(np.isinf(solution.gap.values), np.nan, solution.gap.values)
    assert np.array_equal(arrays["gap"].reshape(ny, nx), wanted, equal_nan=True) and np.isnan(wanted).any()


def test_cells_lie_where_they_should(solution, tmp_path):
    path = tmp_path / "field.vti"
    solution.to_vti(path)
    image, arrays = read(path)
    ny, nx = solution.pressure.values.shape
    for i, j in [(0, 0), (3, 1), (nx - 1, 0), (nx // 2, ny - 1)]:
        x0, x1, y0, y1, *_ = image.GetCell(j * nx + i).GetBounds()
        middle = [solution.pressure.x[i], solution.pressure.y[j]]
        assert [(x0 + x1) / 2, (y0 + y1) / 2] == pytest.approx(middle, abs=1e-9)
        assert arrays["pressure"][j * nx + i] == solution.pressure.values[j, i]


def test_the_command_writes_the_same(command, scenes, tmp_path):
    path, out = tmp_path / "field.vti", tmp_path / "result.json"
    scene = scenes / "tetrahedral_punch.json"
    run = command("solve", scene, "--vti", path, "-o", out)
    assert run.returncode == 0, run.stderr
    _, arrays = read(path)
    assert arrays["pressure"].max() > 0 and arrays["gap"].min() >= 0
    assert '"gap":{"field"' not in out.read_text(), "a field that was asked for as a file alone"
    refused = command("solve", scene, "--vti", scene)
    assert refused.returncode == 2 and "--vti" in refused.stderr
    refused = command("solve", scenes / "depth_list.json", "--vti", path)
    assert refused.returncode == 2 and "--vti" in refused.stderr


def test_without_a_field_it_says_so():
    with pytest.raises(Unsolved, match="outputs"):
        Contact(gap.Cone(45.0), modulus=1.0, depth=1.0).solve().to_vti()
