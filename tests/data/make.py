"""Writes the files beside it, as programs that use VTK do: `python make.py` with the package vtk (9.7 wrote them).

Eight cubes of 2 mm along x, each of other cells; at points x + 2 y + 3 z, its gradient and a tensor; in cells a number.
"""

from itertools import permutations
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

HERE = Path(__file__).parent
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
EDGES_HEX = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
EDGES_TET = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
EDGES_WEDGE = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]


def affine(p):
    return p @ np.array([1.0, 2.0, 3.0])


def tensor(p):
    x, y, z = p.T
    return np.stack([x, y, z, x + y, y + z, x + z], -1)


def mid(p, edges):
    return np.concatenate([p, [(p[a] + p[b]) / 2 for a, b in edges]])


def cubes():
    """Cells as (VTK's number, points): a hexahedron, a voxel, wedges, pyramids, tetrahedra, those of second order."""
    corner = np.array(CORNERS, float)
    middle = np.array([0.5, 0.5, 0.5])
    six = []
    for order in permutations(range(3)):
        steps = [np.zeros(3)]
        for axis in order:
            steps.append(steps[-1] + np.eye(3)[axis])
        six.append(np.array(steps))
    wedges = [corner[[0, 1, 2, 4, 5, 6]], corner[[0, 2, 3, 4, 6, 7]]]
    faces = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    kinds = [
        [(12, corner)],
        [(11, corner[[0, 1, 3, 2, 4, 5, 7, 6]])],
        [(13, w) for w in wedges],
        [(14, np.concatenate([corner[list(f)], [middle]])) for f in faces],
        [(10, t) for t in six],
        [(25, mid(corner, EDGES_HEX))],
        [(26, mid(w, EDGES_WEDGE)) for w in wedges],
        [(24, mid(t, EDGES_TET)) for t in six],
    ]
    return [(k, 2 * (p + np.array([i, 0, 0]))) for i, cells in enumerate(kinds) for k, p in cells]


def arrays(data, points, cells=None):
    for name, values in (("von_mises", affine(points)), ("slope", np.tile([1.0, 2, 3], (len(points), 1)))):
        data.GetPointData().AddArray(named(name, values))
    data.GetPointData().AddArray(named("stress", tensor(points)))
    full = tensor(points)[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    data.GetPointData().AddArray(named("stress9", full))
    count = data.GetNumberOfCells() if cells is None else cells
    data.GetCellData().AddArray(named("material", np.arange(count, dtype=np.int32)))


def named(name, values):
    out = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    out.SetName(name)
    return out


def mesh():
    grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    points.SetDataTypeToDouble()
    listed = [*cubes(), (5, np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]))]  # and a triangle, as a shell
    for kind, places in listed:
        grid.InsertNextCell(kind, len(places), [points.InsertNextPoint(p) for p in places])
    grid.SetPoints(points)
    arrays(grid, np.concatenate([p for _, p in listed]))
    return grid


def image():
    grid = vtk.vtkImageData()
    grid.SetExtent(2, 6, 0, 3, -1, 3)
    grid.SetOrigin(-1, 0, 5)
    grid.SetSpacing(0.5, 1, 2)
    arrays(grid, np.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())]))
    return grid


def write(writer, name, data, mode="Appended", encode=True, compressor=None, big=False, header=32):
    writer.SetFileName(str(HERE / name))
    writer.SetInputData(data)
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetEncodeAppendedData(encode)
    getattr(writer, f"SetCompressorTypeTo{compressor or 'None'}")()
    writer.SetBlockSize(1024)
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    getattr(writer, "SetByteOrderToBigEndian" if big else "SetByteOrderToLittleEndian")()
    assert writer.Write()


if __name__ == "__main__":
    m, i = mesh(), image()
    W, V = vtk.vtkXMLUnstructuredGridWriter, vtk.vtkXMLImageDataWriter
    write(W(), "ascii.vtu", m, "Ascii")
    write(W(), "inline.vtu", m, "Binary", header=64)
    write(W(), "inline_zlib.vtu", m, "Binary", compressor="ZLib")
    write(W(), "appended.vtu", m, encode=False, big=True)
    write(W(), "appended_base64.vtu", m)
    write(W(), "appended_zlib.vtu", m, encode=False, compressor="ZLib", header=64)
    write(W(), "appended_base64_zlib.vtu", m, compressor="ZLib", big=True)
    write(W(), "lzma.vtu", m, encode=False, compressor="LZMA")
    write(W(), "lz4.vtu", m, encode=False, compressor="LZ4")
    write(V(), "ascii.vti", i, "Ascii")
    write(V(), "inline_zlib.vti", i, "Binary", compressor="ZLib")
    write(V(), "appended.vti", i, encode=False)
    write(V(), "appended_zlib.vti", i, encode=False, compressor="ZLib", header=64)
    steps = W()
    steps.SetFileName(str(HERE / "steps.vtu"))
    steps.SetInputData(m)
    steps.SetDataModeToAscii()
    steps.SetNumberOfTimeSteps(2)
    steps.Start()
    for t in (0.0, 1.0):
        m.GetPointData().GetArray("von_mises").Modified()
        m.Modified()
        steps.WriteNextTime(t)
    steps.Stop()
    for version, text in ((42, "legacy42"), (51, "legacy51")):
        for binary in (0, 1):
            for data, name in ((m, "mesh"), (i, "image")):
                w = vtk.vtkDataSetWriter()
                w.SetFileName(str(HERE / f"{text}_{name}_{'binary' if binary else 'ascii'}.vtk"))
                w.SetFileVersion(version)
                w.SetInputData(data)
                w.SetFileType(2 if binary else 1)
                assert w.Write()
    r = vtk.vtkRectilinearGrid()
    r.SetDimensions(3, 4, 3)
    for axis, places in zip("XYZ", ([0, 1, 3], [0, 1, 2, 4], [0, 0.5, 2]), strict=True):
        getattr(r, f"Set{axis}Coordinates")(numpy_to_vtk(np.array(places, float), deep=True))
    arrays(r, np.array([r.GetPoint(k) for k in range(r.GetNumberOfPoints())]))
    s = vtk.vtkStructuredGrid()
    s.SetDimensions(3, 4, 3)
    p = vtk.vtkPoints()
    for k in range(r.GetNumberOfPoints()):
        p.InsertNextPoint(r.GetPoint(k))
    s.SetPoints(p)
    arrays(s, np.array([s.GetPoint(k) for k in range(s.GetNumberOfPoints())]))
    sphere = vtk.vtkSphereSource()
    sphere.Update()
    for data, name in ((r, "rectilinear"), (s, "structured"), (sphere.GetOutput(), "surface")):
        w = vtk.vtkDataSetWriter()
        w.SetFileName(str(HERE / f"{name}.vtk"))
        w.SetInputData(data)
        w.SetFileType(2)
        assert w.Write()
