"""Samples of other programs: what VTK, meshio and pynrrd write is read, cells are rasterised, what is wrong is told."""

from __future__ import annotations

import gzip
import os
import re
import shutil
from collections.abc import Callable
from itertools import permutations
from pathlib import Path
from typing import Any

import meshio
import nrrd
import numpy as np
import pytest
from refused import refused

import porelang
import porelang.cli
from porelang import store
from porelang.data import SampledField
from porelang.diagnostics import Diagnostic, PoreError
from porelang.ops.grid import lookup
from porelang.source import Source, Span
from porelang.tasks import datafile
from porelang.tasks.readers import cells, quadratic, raster, read_grid

#: What VTK itself has written (data/make.py): eight cubes of 2 mm of all kinds of cells, and a grid of 5 x 4 x 5 nodes.
DATA = Path(__file__).parent / "data"
MESHES = sorted(
    p.name for p in DATA.glob("*.vt[uk]") if re.search("^(ascii|inline|appended|lzma|legacy.._mesh)", p.name)
)
IMAGES = sorted(p.name for p in DATA.glob("*.vt[ik]") if re.search(r"\.vti$|_image", p.name))
SPAN = Span(Source("part.pore", 'load("stress.vtu", "von_mises")'), 0, 31)
RNG = np.random.default_rng(9)


@pytest.fixture(autouse=True)
def _afresh(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_CACHE", str(tmp_path_factory.mktemp("kept")))
    datafile.forget()
    store.forget()


def at(grid: SampledField, points: Any, component: int = 0) -> Any:
    x, y, z = (np.ascontiguousarray(c) for c in np.asarray(points, float).T)
    return lookup(grid, x, y, z, (component, 0, 0, 0))


def affine(p: Any) -> Any:
    return p @ np.array([1.0, 2, 3])


def tensor(p: Any) -> Any:
    x, y, z = p.T
    return np.stack([x, y, z, x + y, y + z, x + z], -1)


def told(path: str | Path, name: str = "von_mises", **more: Any) -> Diagnostic:
    return refused(lambda: read_grid(str(path), name, SPAN, **more), SPAN)


# ---- what VTK writes


def test_there_are_files_of_every_way_to_write() -> None:
    assert len(MESHES) == 12
    assert len(IMAGES) == 8


@pytest.mark.parametrize("name", MESHES)
def test_a_field_that_is_linear_is_read_exactly_from_cells_of_all_kinds(name: str) -> None:
    """Hexahedra, voxels, wedges, pyramids, tetrahedra and those of second order, up to the faces of the body."""
    points = RNG.uniform(0, 1, (4000, 3)) * [16, 2, 2]
    points[:1000, 1] = np.round(points[:1000, 1] / 2) * 2
    path = str(DATA / name)
    np.testing.assert_allclose(at(read_grid(path, "von_mises"), points), affine(points), atol=1e-12)
    for k, slope in enumerate((1, 2, 3)):
        np.testing.assert_allclose(at(read_grid(path, "slope"), points, k), slope, atol=1e-12)
    for stress in ("stress", "stress9"):
        grid = read_grid(path, stress)
        for k, expected in enumerate(tensor(points).T):
            np.testing.assert_allclose(at(grid, points, k), expected, atol=1e-12)
    got = raster.Got.of(read_grid(path, "von_mises"))
    assert (got.cells, got.left) == (25, 1)
    assert got.largest_error < 1e-12
    assert (got.least, got.greatest) == (0, 26)


@pytest.mark.parametrize("name", MESHES)
def test_values_in_cells_are_constant_in_each(name: str) -> None:
    grid = read_grid(str(DATA / name), "material", voxel=0.2)
    middles = np.array([[1, 1, 1], [3, 1, 1], [11, 1, 1]])
    np.testing.assert_array_equal(at(grid, middles), [0, 1, 16])
    around = RNG.uniform(-0.7, 0.7, (100, 3)) + middles[2]
    np.testing.assert_array_equal(at(grid, around), 16)


@pytest.mark.parametrize("name", IMAGES)
def test_a_grid_of_vtks_is_read_to_the_bit(name: str) -> None:
    grid = read_grid(str(DATA / name), "von_mises")
    assert (grid.shape, grid.origin, grid.spacing) == ((5, 4, 5), (0, 0, 3), (0.5, 1, 2))
    places = np.stack(np.meshgrid(np.arange(5) * 0.5, np.arange(4.0), 3 + 2 * np.arange(5.0), indexing="ij"), -1)
    np.testing.assert_array_equal(grid.values[..., 0], affine(places))
    stress = read_grid(str(DATA / name), "stress9")
    np.testing.assert_array_equal(stress.values, tensor(places.reshape(-1, 3)).reshape(5, 4, 5, 6))
    material = read_grid(str(DATA / name), "material", masked=True)
    assert material.components == 2
    middles = np.array([[0.25, 0.5, 4], [0.75, 0.5, 4], [1.75, 2.5, 10]])
    np.testing.assert_array_equal(at(material, middles), [0, 1, 47])
    edges = np.array([[0, 0.5, 4], [2, 0.5, 4], [0.25, 0, 4], [0.25, 3, 4], [0.25, 0.5, 3], [0.25, 0.5, 11]])
    np.testing.assert_allclose(at(material, edges, 1), 0, atol=1e-12)


@pytest.mark.parametrize("name", ["rectilinear.vtk", "structured.vtk"])
def test_other_grids_become_hexahedra(name: str) -> None:
    points = RNG.uniform(0, 1, (500, 3)) * [3, 4, 2]
    np.testing.assert_allclose(at(read_grid(str(DATA / name), "von_mises"), points), affine(points), atol=1e-12)
    assert raster.Got.of(read_grid(str(DATA / name), "material")).cells == 12


def test_components_are_those_that_the_file_names(tmp_path: Path) -> None:
    """Abaqus has xx, yy, zz, xy, xz, yz; a file that says so is read so."""
    names = " ".join(f'ComponentName{k}="S{n}"' for k, n in enumerate(("11", "22", "33", "12", "13", "23")))
    text = (DATA / "ascii.vtu").read_text().replace('Name="stress" ', f'Name="stress" {names} ', 1)
    text = re.sub(r"ComponentName\d=\"[xyzXYZ]+\" ", "", text)
    (tmp_path / "a.vtu").write_text(text)
    points = RNG.uniform(0, 1, (50, 3)) * [16, 2, 2]
    grid = read_grid(str(tmp_path / "a.vtu"), "stress")
    for k, meant in enumerate((0, 1, 2, 3, 5, 4)):
        np.testing.assert_allclose(at(grid, points, k), tensor(points)[:, meant], atol=1e-12)


def test_pieces_are_one_mesh(tmp_path: Path) -> None:
    """Of several pieces, one of which is empty, as programs write that compute on several machines."""
    text = (DATA / "ascii.vtu").read_text()
    begin, end = text.index("<Piece"), text.index("</Piece>") + len("</Piece>")
    piece = text[begin:end]
    empty = '<Piece NumberOfPoints="0" NumberOfCells="0"><PointData/><Points/><Cells/></Piece>'
    (tmp_path / "a.vtu").write_text(text[:begin] + piece + empty + piece + text[end:])
    grid = read_grid(str(tmp_path / "a.vtu"), "von_mises")
    points = RNG.uniform(0, 1, (500, 3)) * [16, 2, 2]
    np.testing.assert_allclose(at(grid, points), affine(points), atol=1e-12)
    assert raster.Got.of(grid).cells == 50
    assert raster.Got.of(read_grid(str(tmp_path / "a.vtu"), "material")).greatest == 24


# ---- rasterising


def kuhn(n: int, size: float, keep: Callable[[Any], Any] | None = None, jitter: float = 0.0) -> tuple[Any, Any]:
    """The points and tetrahedra of n^3 cubes about the origin, six in each, of the cubes that are kept."""
    axis = np.arange(n + 1.0)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    inner = ((points > 0) & (points < n)).all(axis=1)
    points[inner] += np.random.default_rng(1).uniform(-jitter, jitter, (int(inner.sum()), 3))
    cubes = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).reshape(-1, 3)
    if keep is not None:
        cubes = cubes[keep((cubes + 0.5) * size / n - size / 2)]
    made = []
    for order in permutations(range(3)):
        corner = cubes.copy()
        row = [corner @ [(n + 1) ** 2, n + 1, 1]]
        for axis_ in order:
            corner = corner + np.eye(3, dtype=int)[axis_]
            row.append(corner @ [(n + 1) ** 2, n + 1, 1])
        made.append(np.stack(row, axis=1))
    return points * size / n - size / 2, np.concatenate(made)


def write(path: Path, points: Any, kind: str, listed: Any, **arrays: Any) -> Path:
    meshio.write(path, meshio.Mesh(points, [(kind, listed)], point_data=arrays))
    return path


def test_a_bent_field_is_linear_in_each_cell(tmp_path: Path) -> None:
    """At each node the value is that of barycentric coordinates, computed anew by solving for them."""
    points, tetrahedra = kuhn(4, 8.0, jitter=0.2)
    values = np.sin(points[:, 0]) * points[:, 1] + points[:, 2] ** 2
    grid = read_grid(str(write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=values)), "s", voxel=0.5)
    axes = [o + s * np.arange(n) for o, s, n in zip(grid.origin, grid.spacing, grid.shape, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    met = 0
    for corners in tetrahedra:
        p = points[corners]
        inverse = np.linalg.inv(np.concatenate([p.T, np.ones((1, 4))]))
        b = np.concatenate([nodes, np.ones((*nodes.shape[:3], 1))], -1) @ inverse.T
        inside = (b > -1e-12).all(axis=-1)
        np.testing.assert_allclose(grid.values[inside, 0], b[inside] @ values[corners], atol=1e-11)
        met += int(inside.sum())
    assert met >= 17**3


def test_the_error_that_is_told_bounds_what_lookups_do(tmp_path: Path) -> None:
    """Against the field of the cells at points that were not looked at: 95 % within the first figure, about."""
    points, tetrahedra = kuhn(10, 20.0, jitter=0.2)
    values = points[:, 0] ** 2 + points[:, 1]
    path = write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=values)
    grid = read_grid(str(path), "s")
    got = raster.Got.of(grid)
    assert 0.05 < got.error <= got.largest_error < 4
    np.testing.assert_allclose(got.voxel, 0.5 * np.median(np.min(edges(points, tetrahedra), axis=0)), rtol=1e-12)
    rng = np.random.default_rng(3)
    weights = rng.dirichlet(np.ones(4), len(tetrahedra))
    inside = np.einsum("tc,tcx->tx", weights, points[tetrahedra])
    wrong = np.abs(at(grid, inside) - (weights * values[tetrahedra]).sum(axis=1))
    assert np.quantile(wrong, 0.95) <= got.error
    assert wrong.max() <= 1.05 * got.largest_error
    finer = raster.Got.of(read_grid(str(path), "s", voxel=got.voxel / 4))
    assert finer.error < got.error / 3
    assert f"{got.error:.3g}" in got.told(grid, 1)


def edges(points: Any, tetrahedra: Any) -> Any:
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    return [np.linalg.norm(points[tetrahedra[:, a]] - points[tetrahedra[:, b]], axis=1) for a, b in pairs]


def test_outside_begins_at_the_faces_of_the_cells(tmp_path: Path) -> None:
    """An L of cubes: depths are distances to its border, linear fields go on beyond it, far nodes have the nearest."""
    points, tetrahedra = kuhn(6, 12.0, lambda c: (c[:, 0] < 0) | (c[:, 1] < 0))
    path = write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=affine(points))
    grid = read_grid(str(path), "s", voxel=0.5, masked=True)
    rng = np.random.default_rng(5)
    q = rng.uniform(-6, 6, (4000, 3))
    x, y, _ = q.T
    inside = (x < 0) | (y < 0)
    np.testing.assert_allclose(at(grid, q)[inside], affine(q)[inside], atol=1e-12)
    depth = at(grid, q, 1)
    clear = (np.abs(x) > 1e-9) & (np.abs(y) > 1e-9)
    far = ~((np.abs(x) < 0.5) & (np.abs(y) < 0.5))  # about the edge inside, distances bend within a step
    assert ((depth <= 0) == inside)[clear & far].all()
    near = ~inside & (np.minimum(x, y) < 0.5) & (np.maximum(x, y) > 0.5)
    np.testing.assert_allclose(depth[near], np.minimum(x, y)[near], atol=1e-9)
    corner = at(grid, [[6.0, 6.0, 0.0]])[0]
    assert affine(np.array([0, 6.0, 0])) - 3 < corner < affine(np.array([0, 6.0, 0])) + 3 or corner < 12 + 3


def test_a_body_that_is_turned_is_as_exact(tmp_path: Path) -> None:
    """No node lies on its faces: lookups next to them read nodes outside, where the field of the cells goes on."""
    points, tetrahedra = kuhn(4, 8.0, jitter=0.2)
    c, s = np.cos(0.5), np.sin(0.5)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    path = write(tmp_path / "a.vtu", points @ turn.T, "tetra", tetrahedra, s=affine(points @ turn.T))
    grid = read_grid(str(path), "s", voxel=0.6, masked=True)
    rng = np.random.default_rng(6)
    q = rng.uniform(-4, 4, (3000, 3))
    q[:1500, 0] = 4 * np.sign(q[:1500, 0])  # on two of its faces
    np.testing.assert_allclose(at(grid, q @ turn.T), affine(q @ turn.T), atol=1e-11)
    wide = rng.uniform(-4.6, 4.6, (4000, 3))
    away = np.abs(wide).max(axis=1) - 4
    depth = at(grid, wide @ turn.T, 1)
    step = grid.spacing[0]
    # near a face, and not about an edge, where distances bend
    clear = (np.sort(np.abs(np.abs(wide) - 4), axis=1)[:, 1] > 2.5 * step) & (np.abs(away) < 0.25 * step)
    assert clear.sum() > 50
    np.testing.assert_allclose(depth[clear], away[clear], atol=1e-9)
    assert raster.Got.of(grid).largest_error < 1e-11


def test_points_that_are_written_once_for_each_cell_are_one(tmp_path: Path) -> None:
    """As programs do whose fields jump between cells: the border is that of the body, not of every cell."""
    points, tetrahedra = kuhn(3, 6.0)
    apart = points[tetrahedra].reshape(-1, 3)
    own = np.arange(len(apart)).reshape(-1, 4)
    faces, _ = raster.border(apart, own)
    assert len(faces) == 6 * 9 * 2
    grid = read_grid(str(write(tmp_path / "a.vtu", apart, "tetra", own, s=affine(apart))), "s")
    q = np.random.default_rng(1).uniform(-3, 3, (500, 3))
    np.testing.assert_allclose(at(grid, q), affine(q), atol=1e-12)


def test_cells_with_shared_faces_are_cut_alike() -> None:
    """Hexahedra whose corners are numbered at random: all faces but those of the border are there twice."""
    n = 3
    axis = np.arange(n + 1.0)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    turn = np.random.default_rng(2).permutation(len(points))
    place = np.empty_like(turn)
    place[turn] = np.arange(len(points))
    low = np.array([(i * (n + 1) + j) * (n + 1) + k for i in range(n) for j in range(n) for k in range(n)])
    around = np.array([0, (n + 1) ** 2, (n + 1) ** 2 + n + 1, n + 1])
    corners = place[low[:, None] + np.concatenate([around, around + 1])]
    made, owner = cells._tetrahedra(cells.HEXAHEDRON, corners)
    faces, _ = raster.border(points[turn], made)
    assert len(faces) == 6 * n * n * 2
    p = points[turn][made]
    volume = np.abs(np.linalg.det(p[:, 1:] - p[:, :1])) / 6
    np.testing.assert_allclose(np.bincount(owner, volume), 1)


@pytest.mark.parametrize("name", ["a.vtu", "a.vtk"])
@pytest.mark.parametrize("binary", [True, False])
def test_what_meshio_writes_is_read(name: str, binary: bool, tmp_path: Path) -> None:
    points, tetrahedra = kuhn(3, 6.0)
    mesh = meshio.Mesh(points, [("tetra", tetrahedra)], point_data={"s": affine(points), "v": points},
                       cell_data={"c": [np.arange(len(tetrahedra))]})  # fmt: skip
    for version in [None] if name.endswith("u") else ["vtk42", "vtk51"]:
        meshio.write(tmp_path / name, mesh, **({} if version is None else {"file_format": version}), binary=binary)
        q = np.random.default_rng(1).uniform(-3, 3, (500, 3))
        np.testing.assert_allclose(at(read_grid(str(tmp_path / name), "s"), q), affine(q), atol=1e-12)
        np.testing.assert_allclose(at(read_grid(str(tmp_path / name), "v"), q, 2), q[:, 2], atol=1e-12)
        assert raster.Got.of(read_grid(str(tmp_path / name), "c")).greatest == len(tetrahedra) - 1
        datafile.forget()


def test_samples_of_cells_are_kept_by_what_is_in_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []
    work = raster.rasterised
    monkeypatch.setattr(raster, "rasterised", lambda a, c, voxel: (made.append(voxel), work(a, c, voxel))[1])
    points, tetrahedra = kuhn(2, 4.0)
    path = str(write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=affine(points), t=points[:, 0]))
    first = read_grid(path, "s", masked=True)

    def again(path: str, name: str = "s", **more: Any) -> SampledField:
        datafile.forget()
        store.forget()
        return read_grid(path, name, **more)

    shutil.copy(path, tmp_path / "b.vtu")
    second = again(str(tmp_path / "b.vtu"), masked=True)
    assert (second.digest, second.facts) == (first.digest, first.facts)
    assert again(path).components == 1
    np.testing.assert_array_equal(again(path).values[..., 0], first.values[..., 0])
    assert made == [0.0]
    again(path, "t")
    again(path, voxel=0.5)
    write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=affine(points) + 1)
    assert again(path).values[1, 1, 1, 0] == first.values[1, 1, 1, 0] + 1
    assert made == [0.0, 0.0, 0.5, 0.0]


# ---- NRRD

VALUES = RNG.random((4, 5, 6))


@pytest.mark.parametrize("encoding", ["raw", "gzip", "ascii"])
@pytest.mark.parametrize("dtype", ["<f4", ">f8", "<i2", "u1"])
def test_what_pynrrd_writes_is_read(encoding: str, dtype: str, tmp_path: Path) -> None:
    values = (VALUES * 100).astype(dtype)
    header = {"space": "left-posterior-superior", "space directions": np.diag([0.5, 1, 2]), "space origin": [1, 2, 3]}
    nrrd.write(str(tmp_path / "scan.nrrd"), values, {**header, "encoding": encoding})
    grid = read_grid(str(tmp_path / "scan.nrrd"), "scan")
    np.testing.assert_array_equal(grid.values[..., 0], values)
    assert (grid.origin, grid.spacing) == ((1, 2, 3), (0.5, 1, 2))


def test_axes_of_a_nrrd_may_run_in_any_order(tmp_path: Path) -> None:
    directions = [[0, -2.0, 0], [0, 0, 0.5], [1.0, 0, 0]]
    header = {"space dimension": 3, "space directions": directions, "space origin": [0, 10, 0], "content": "density"}
    nrrd.write(str(tmp_path / "scan.nrrd"), VALUES, {**header, "encoding": "raw", "space units": ["cm"] * 3})
    grid = read_grid(str(tmp_path / "scan.nrrd"), "density")
    assert (grid.shape, grid.origin, grid.spacing) == ((6, 4, 5), (0, 40, 0), (10, 20, 5))
    for i, j, k in ((0, 0, 0), (3, 2, 5), (1, 4, 2)):
        place = 10 * (np.array([0, 10, 0]) + i * np.array(directions[0]) + j * np.array(directions[1])
                      + k * np.array(directions[2]))  # fmt: skip
        np.testing.assert_allclose(at(grid, [place])[0], VALUES[i, j, k], rtol=1e-12)


def test_vectors_and_tensors_of_a_nrrd(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    path = str(tmp_path / "a.nrrd")
    vectors = rng.random((3, 4, 5, 6))
    base = {"encoding": "raw", "space dimension": 3, "space origin": [0, 0, 0]}
    along = [[np.nan] * 3, [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]
    nrrd.write(path, vectors, {**base, "space directions": along, "kinds": ["vector", *["domain"] * 3]})
    np.testing.assert_array_equal(read_grid(path, "a").values, np.moveaxis(vectors, 0, -1))
    six = rng.random((4, 5, 6, 6))
    kinds = [*["domain"] * 3, "3D-symmetric-matrix"]
    nrrd.write(path, six, {**base, "space directions": [*along[1:], along[0]], "kinds": kinds})
    datafile.forget()
    np.testing.assert_array_equal(read_grid(path, "a").values, six[..., [0, 3, 5, 1, 4, 2]])


# ---- what is wrong


def ascii_mesh() -> str:
    return (DATA / "ascii.vtu").read_text()


def put(path: Path, text: str | bytes) -> None:
    path.write_bytes(text.encode() if isinstance(text, str) else text)


def copied(path: Path, name: str, change: Callable[[bytes], bytes] = lambda b: b) -> None:
    path.write_bytes(change((DATA / name).read_bytes()))


def swapped(name: str, old: bytes, new: bytes) -> Callable[[Path], object]:
    """Writes a file of VTK's with some of it changed."""
    content = (DATA / name).read_bytes()
    assert old in content
    return lambda p: p.write_bytes(content.replace(old, new, 1))


def half(content: bytes) -> bytes:
    return content[: len(content) // 2]


def header(more: str, data: bytes, sizes: str = "2 2 2", encoding: str = "raw") -> Callable[[Path], object]:
    """Writes a .nrrd of float32 with that in its header and after it."""
    text = f"NRRD0004\ntype: float\ndimension: {len(sizes.split())}\nsizes: {sizes}\nencoding: {encoding}\n"
    return lambda p: p.write_bytes(f"{text}endian: little\ncontent: von_mises\n{more}\n".encode() + data)


UPRIGHT = "space directions: (1,0,0) (0,1,0) (0,0,1)\n"
MESH42, MESH51 = "legacy42_mesh_ascii.vtk", "legacy51_mesh_binary.vtk"
MILLIONS = b'NumberOfCells="1000000000000"'
EXTENT = b'WholeExtent="2 6 0 3 -1 3"'
CORNERS = b"8 0 1 2 3 4 5 6 7"
ENTITY = '<!DOCTYPE a [<!ENTITY b "c">]><VTKFile>&b;</VTKFile>'
HOSTILE: dict[str, tuple[str, str, Callable[[Path], object], str]] = {
    "a folder": ("a.vtu", "E130", Path.mkdir, "is a folder"),
    "a pipe": ("a.vtk", "E130", os.mkfifo, "is a pipe"),
    "a link to a device": ("a.vti", "E130", lambda p: p.symlink_to("/dev/zero"), "is a device"),
    "nothing": ("a.nrrd", "E130", lambda p: None, "no file"),
    "empty": ("a.vtu", "E131", lambda p: put(p, ""), "no file of VTK"),
    "empty vtk": ("a.vtk", "E131", lambda p: put(p, ""), "no .vtk file"),
    "empty nrrd": ("a.nrrd", "E131", lambda p: put(p, ""), "no .nrrd file"),
    "no xml": ("a.vtu", "E131", lambda p: put(p, b"\x00\xff" * 50), "no file of VTK"),
    "another xml": ("a.vtu", "E131", lambda p: put(p, "<svg/>"), "<svg>"),
    "xml in .vtk": ("a.vtk", "E131", lambda p: copied(p, "ascii.vtu"), "no .vtk file"),
    "entities": ("a.vtu", "E131", lambda p: put(p, ENTITY), "words of"),
    "an image in .vtu": ("a.vtu", "E131", lambda p: copied(p, "ascii.vti"), "holds ImageData"),
    "a surface": ("a.vtk", "E131", lambda p: copied(p, "surface.vtk"), "POLYDATA"),
    "lz4": ("a.vtu", "E131", lambda p: copied(p, "lz4.vtu"), "by LZ4"),
    "another array": ("a.vtu", "E132", swapped("ascii.vtu", b'"von_mises"', b'"von_mies"'), "no array"),
    "several steps": ("a.vtu", "E151", lambda p: copied(p, "steps.vtu"), "time steps"),
    "10^12 cells": ("a.vtu", "E135", swapped("appended.vtu", b'NumberOfCells="26"', MILLIONS), "1,000,000,000,000 num"),
    "10^12 points": ("a.vtk", "E135", swapped(MESH51, b"POINTS 195", b"POINTS 1000000000000"), "24,000,000,000,000"),
    "10^8 points": ("a.vtk", "E131", swapped(MESH51, b"POINTS 195", b"POINTS 70000000"), "cut short"),
    "10^12 nodes": ("a.vti", "E135", swapped("appended.vti", EXTENT, EXTENT.replace(b"6", b"9" * 12)), "999,998 nodes"),
    "a huge number": ("a.vtu", "E131", swapped("ascii.vtu", b'"26"', b'"' + b"9" * 6000 + b'"'), "999"),
    "a kind of cell": ("a.vtk", "E150", swapped(MESH42, b"\n12\n", b"\n42\n"), "polyhedra"),
    "no such point": ("a.vtk", "E131", swapped(MESH42, CORNERS, CORNERS + b"77"), "777 of 195"),
    "too many points": ("a.vtk", "E131", swapped(MESH42, CORNERS, b"7" + CORNERS[1:]), "longer or shorter"),
    "a word": ("a.vtk", "E131", swapped(MESH42, b"POINT_DATA", b"POINTDATA"), "POINTDATA"),
    "an offset": ("a.vtu", "E131", swapped("appended.vtu", b'offset="0"', b'offset="99999999"'), "cut short"),
    "a negative offset": ("a.vtu", "E131", swapped("appended.vtu", b'offset="0"', b'offset="-5"'), "damaged"),
    "infinite": ("a.vtk", "E134", swapped(MESH42, b"0 0 0 2 0 0", b"0 0 inf 2 0 0"), "no places"),
    "far": ("a.vtk", "E134", swapped(MESH42, b"0 0 0 2 0 0", b"0 0 1e9 2 0 0"), "1e+09 mm"),
    "a detached array": ("a.nrrd", "E131", lambda p: put(p, "NRRD0004\ndata file: /dev/zero\n\n"), "another file"),
    "no place": ("a.nrrd", "E132", header("", bytes(32)), "where its grid lies"),
    "10^12 numbers": ("a.nrrd", "E135", header(UPRIGHT, bytes(32), "10000 10000 10000", "gzip"), "1,000,000,000,000"),
    "too few bytes": ("a.nrrd", "E131", header(UPRIGHT, bytes(31)), "cut short"),
    "a bomb": ("a.nrrd", "E131", header(UPRIGHT, gzip.compress(bytes(10**8)), "2 2 2", "gzip"), "more in it"),
    "steps in .nrrd": ("a.nrrd", "E151", header("kinds: domain domain domain time\n", b"", "2 2 2 2"), "time steps"),
    "four axes": ("a.nrrd", "E151", header("", b"", "7 2 2 2"), "time steps"),
    "two axes": ("a.nrrd", "E133", header("", b"", "2 2"), "no grid"),
    "bzip2": ("a.nrrd", "E131", header(UPRIGHT, bytes(32), "2 2 2", "bzip2"), "bzip2"),
    "turned": ("a.nrrd", "E133", header("space directions: (1,1,0) (-1,1,0) (0,0,1)\n", bytes(32)), "turned"),
    "furlongs": ("a.nrrd", "E133", header(f'{UPRIGHT}space units: "fur" "fur" "fur"\n', bytes(32)), "`fur`"),
    "an infinite step": ("a.nrrd", "E134", header(UPRIGHT.replace("(1", "(inf"), bytes(32)), "no place"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_what_is_wrong_is_told_at_the_call(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    name, code, make, words = HOSTILE[case]
    make(tmp_path / name)
    found = told(name)
    assert (found.code, words in found.message) == (code, True), found.message


@pytest.mark.parametrize("name", [*MESHES, *IMAGES, "structured.vtk"])
def test_a_file_that_was_cut_short_is_refused(name: str, tmp_path: Path) -> None:
    copied(tmp_path / name, name, half)
    found = told(tmp_path / name)
    assert found.code in ("E131", "E132")
    for share in (0.1, 0.3, 0.7, 0.9):
        copied(tmp_path / name, name, lambda b, share=share: b[: int(share * len(b))])  # type: ignore[misc]
        assert told(tmp_path / name, "stress9").code in ("E131", "E132")


@pytest.mark.parametrize("name", ["appended_zlib.vtu", "inline_zlib.vti", "legacy51_mesh_binary.vtk", "ascii.vtu"])
def test_a_broken_file_never_ends_in_a_traceback(name: str, tmp_path: Path) -> None:
    """Files with bytes changed at random: samples or a diagnostic."""
    good = (DATA / name).read_bytes()
    dice = np.random.default_rng(7)
    refused = 0
    for _ in range(60):
        content = bytearray(good)
        for _ in range(int(dice.integers(1, 8))):
            content[dice.integers(len(content))] = dice.integers(256)
        (tmp_path / name).write_bytes(content)
        try:
            read_grid(str(tmp_path / name), "von_mises", SPAN)
        except PoreError:
            refused += 1
    assert refused > 5


def test_not_a_number_counts_where_cells_read_it(tmp_path: Path) -> None:
    points, tetrahedra = kuhn(2, 4.0)
    values = affine(points)
    more = np.concatenate([points, [[9e9, 0, 0]]])  # a point that no cell has
    path = write(tmp_path / "a.vtu", more, "tetra", tetrahedra, s=np.append(values, np.nan))
    assert raster.Got.of(read_grid(str(path), "s")).largest_error < 1e-12
    values[13] = np.nan
    found = told(write(tmp_path / "b.vtu", points, "tetra", tetrahedra, s=values), "s")
    assert found.code == "E134"
    assert "point 13, (0, 0, 0)" in found.message


def test_cells_without_a_volume_are_told(tmp_path: Path) -> None:
    points, _ = kuhn(1, 4.0)
    found = told(write(tmp_path / "a.vtu", points, "triangle", np.array([[0, 1, 2]]), s=points[:, 0]), "s")
    assert found.code == "E150"
    assert "only triangles" in found.message
    assert "in a plane" in found.hint  # these three points are
    flat = told(write(tmp_path / "b.vtu", points * [1, 1, 0], "tetra", np.array([[0, 1, 2, 4]]), s=points[:, 0]), "s")
    assert "in a plane" in flat.message


#: The edges of a hexahedron and of a wedge, in the order of the points in their middles (VTK's User's Guide, figure 3).
QUADRATIC = {
    "hexahedron20": (
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
    ),
    "wedge15": (
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
        [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    ),
}


@pytest.mark.parametrize("kind", QUADRATIC)
def test_all_points_of_cells_of_second_order_count(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two cells beside each other: exact at all of their points and in their middles, and without a gap between."""
    monkeypatch.setitem(meshio._mesh.topological_dimension, "wedge15", 3)  # which meshio writes, once it knows that
    corners, pairs = np.array(QUADRATIC[kind][0], float), QUADRATIC[kind][1]
    one = 8 * np.concatenate([corners, [(corners[a] + corners[b]) / 2 for a, b in pairs]])
    points = np.concatenate([one, one * [1, 1, -1]])
    values = points[:, 0] ** 2 - points[:, 1] * points[:, 2]
    cell = np.arange(len(one))
    path = str(write(tmp_path / "a.vtu", points, kind, np.array([cell, cell + len(one)]), s=values))
    grid = read_grid(path, "s", voxel=1, masked=True)
    np.testing.assert_allclose(at(grid, points), values, atol=1e-9)
    middle = 8 * corners.mean(axis=0)
    found = quadratic.middles(np.concatenate([points, values[:, None]], axis=1), cell[None])
    np.testing.assert_allclose(found, [[*middle, middle[0] ** 2 - middle[1] * middle[2]]], atol=1e-12)
    got = raster.Got.of(grid)
    assert (got.cells, got.corners, got.lost) == (2, 0, 0)
    through = np.stack([np.full(50, 2.0), np.full(50, 2.0), np.linspace(-7.5, 7.5, 50)], -1)
    assert (at(grid, through, 1) < 0).all()
    linear = str(write(tmp_path / "b.vtu", points, kind, np.array([cell, cell + len(one)]), s=affine(points)))
    inside = RNG.dirichlet(np.ones(6), 300) @ (8 * corners[:6])
    np.testing.assert_allclose(at(read_grid(linear, "s", voxel=1), inside), affine(inside), atol=1e-9)


def test_a_jump_is_no_sign_of_samples_that_are_too_coarse(tmp_path: Path) -> None:
    """Points that lie on each other, with a value for either side."""
    points, tetrahedra = kuhn(4, 8.0)
    both = np.concatenate([points - [4.0, 0, 0], points - [-4.0, 0, 0]])
    values = np.concatenate([np.zeros(len(points)), np.full(len(points), 90.0)])
    cells_of = np.concatenate([tetrahedra, tetrahedra + len(points)])
    got = raster.Got.of(read_grid(str(write(tmp_path / "a.vtu", both, "tetra", cells_of, s=values)), "s"))
    assert got.error == 0
    assert not got.coarse


def test_thin_walls_are_sampled_finely_enough(tmp_path: Path) -> None:
    """A plate of flat cells at 45 degrees; with a voxel twice its width there is hardly an inside, which is told."""
    points, tetrahedra = kuhn(8, 40.0)
    points = points * [1, 1, 0.1]
    turn = np.array([[1, 0, 1], [0, np.sqrt(2), 0], [-1, 0, 1]]) / np.sqrt(2)
    path = write(tmp_path / "a.vtu", points @ turn.T, "tetra", tetrahedra, s=points[:, 2])
    assert raster.Got.of(read_grid(str(path), "s")).lost == 0
    text = 'let s = load("a.vtu", "s", outside=-9{})\nout part = s + 0'
    assert len(program(tmp_path, text.format("")).notes()) == 1
    with pytest.warns(porelang.PoreWarning, match="too coarse for walls so thin"):
        program(tmp_path, text.format(", voxel=9mm")).notes()


def test_what_is_no_number_is_outside(tmp_path: Path) -> None:
    """Where it is said what holds there; half a step from the nodes that have a value, which are as they were."""
    values = np.fromfunction(lambda i, j, k: i + 2 * j + 3 * k, (9, 9, 9))
    values[np.fromfunction(lambda i, j, k: i > 5, (9, 9, 9))] = np.nan
    np.savez(tmp_path / "a.npz", s=values, origin=[0, 0, 0], spacing=1)
    found = told(tmp_path / "a.npz", "s")
    assert found.code == "E134"
    assert "`outside=0`" in found.hint
    made = program(tmp_path, 'out s = load("a.npz", "s", outside=-7)')
    q = np.array([[1.0, 2, 3], [5, 2, 3], [5.4, 2, 3], [5.6, 2, 3], [8, 8, 8], [9, 0, 0]])
    np.testing.assert_allclose(made.field("s")(q), [14, 18, 18, -7, -7, -7], atol=1e-12)
    values[0, 0, 0] = np.inf
    np.savez(tmp_path / "b.npz", s=values, origin=[0, 0, 0], spacing=1)
    assert told(tmp_path / "b.npz", "s", masked=True).code == "E134"


def test_cells_whose_corners_lie_on_each_other_are_refused(tmp_path: Path) -> None:
    points, tetrahedra = kuhn(1, 4.0)
    flat = tetrahedra[:, [0, 1, 2, 2]]
    found = told(write(tmp_path / "a.vtu", points, "tetra", flat, s=points[:, 0]), "s")
    assert found.code == "E150"
    assert "has a volume" in found.message


#: The names of components, and where xx, yy, zz, xy, yz, xz stand.
NAMES = {
    "abaqus": (["S11", "S22", "S33", "S12", "S13", "S23"], [0, 1, 2, 3, 5, 4]),
    "voigt": (["xx", "yy", "zz", "yz", "xz", "xy"], [0, 1, 2, 5, 3, 4]),
    "with a unit": (["xx (MPa)", "yy (MPa)", "zz (MPa)", "xy (MPa)", "xz (MPa)", "yz (MPa)"], [0, 1, 2, 3, 5, 4]),
    "words": ([f"Stress {n} component" for n in (11, 22, 33, 12, 31, 23)], [0, 1, 2, 3, 5, 4]),
    "code_aster": (["SIXX", "SIYY", "SIZZ", "SIXY", "SIXZ", "SIYZ"], [0, 1, 2, 3, 5, 4]),
    "numbers": (list("012345"), [0, 1, 2, 3, 4, 5]),
    "one twice": (["S11", "S22", "S33", "S12", "S12", "S23"], [0, 1, 2, 3, 4, 5]),
}


@pytest.mark.parametrize("case", NAMES)
def test_a_tensor_is_taken_by_the_names_of_its_components(case: str, tmp_path: Path) -> None:
    names, order = NAMES[case]
    numbers = np.array([10.0, 20, 30, 40, 50, 60])
    points, tetrahedra = kuhn(1, 4.0)
    write(tmp_path / "a.vtu", points, "tetra", tetrahedra, T=np.tile(numbers, (len(points), 1)))
    text = (tmp_path / "a.vtu").read_text()
    named = " ".join(f'ComponentName{k}="{n}"' for k, n in enumerate(names))
    (tmp_path / "a.vtu").write_text(text.replace('Name="T"', f'Name="T" {named}'))
    listed = "\n".join(n.replace(" ", "%20") for n in names)
    rows = "\n".join(" ".join(f"{v:g}" for v in numbers) for _ in points)
    legacy = (
        "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\n"
        f"SPACING 1 1 1\nPOINT_DATA 8\nFIELD FieldData 2\nT 6 8 double\n{rows}\nMETADATA\nCOMPONENT_NAMES\n{listed}\n"
        "INFORMATION 0\n\nother 1 8 double\n1 2 3 4 5 6 7 8\nMETADATA\nINFORMATION 0\n\n"
    )
    (tmp_path / "a.vtk").write_text(legacy)
    for ending in (".vtu", ".vtk"):
        grid = read_grid(str(tmp_path / f"a{ending}"), "T")
        np.testing.assert_allclose([at(grid, [[0.5, 0.5, 0.5]], k)[0] for k in range(6)], numbers[order], rtol=1e-12)
        got = raster.Got.of(grid)
        assert got.named == (case not in ("numbers", "one twice"))
        assert ("does not name" in got.told(grid, 6)) != got.named


def test_a_tensor_that_is_not_symmetric_is_refused(tmp_path: Path) -> None:
    points, tetrahedra = kuhn(1, 4.0)
    skew = np.tile([1.0, 2, 3, 2, 1, 0, 3, 0.5, 1], (len(points), 1))
    found = told(write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=skew), "s")
    assert found.code == "E133"
    assert "differ by 0.5" in found.message


def test_a_voxel_that_does_not_fit_is_told(tmp_path: Path) -> None:
    assert told(DATA / "ascii.vti", voxel=0.5).code == "E152"
    found = told(DATA / "ascii.vtu", voxel=1e-4)
    assert found.code == "E152"
    enough = re.search(r"of ([\d.e-]+) mm", found.hint)
    assert enough is not None
    assert float(enough[1]) < 0.02


def test_names_that_are_near_are_offered(tmp_path: Path) -> None:
    found = told(DATA / "ascii.vtu", "vonmises")
    assert (found.code, "did you mean `von_mises`?" in found.hint, "`material`" in found.hint) == ("E132", True, True)
    shutil.copy(DATA / "ascii.vtu", tmp_path / "stress.vtu")
    assert "stress.vtu`?" in told(tmp_path / "stres.vtu").hint
    assert "stress.vtu`?" in told(tmp_path / "stress.npz").hint
    for other, way_out in (("a.pvd", "one of those"), ("a.pvtu", "one of those"), ("a.odb", "as .vtu"),
                           ("a.csv", "griddata"), ("b.msh", '`meshio.read("b.msh").write("b.vtu")`'),
                           ("a.nhdr", ".nrrd"), ("a.txt", "name a .npz")):  # fmt: skip
        put(tmp_path / other, "")
        assert told(tmp_path / other).code == "E131"
        assert way_out in told(tmp_path / other).hint


# ---- in the language


def program(folder: Path, text: str) -> porelang.program.Program:
    path = folder / "part.pore"
    path.write_text(text)
    return porelang.compile(path=path)


def test_a_field_of_cells_drives_a_lattice(tmp_path: Path, backend: str) -> None:
    points, tetrahedra = kuhn(6, 12.0, lambda c: np.hypot(c[:, 0], c[:, 1]) < 5)
    write(tmp_path / "stress.vtu", points, "tetra", tetrahedra, von_mises=affine(points), u=points, t=tensor(points))
    design = program(
        tmp_path,
        """let s = load("stress.vtu", "von_mises", outside=-100)
let u = load_vector("stress.vtu", "u", voxel=0.5mm)
let t = load_tensor("stress.vtu", "t", outside=7)
out s_ = s
out u_ = u
out t_ = [t.xx, t.yz, t.xz]
out part = gyroid(6) |> shell(0.8) |> thicken(-s / 40, 0.4) & cylinder(4, 12)
""",
    ).design()
    q = np.random.default_rng(1).uniform(-2.5, 2.5, (200, 3))
    far = np.array([[5.5, 5.5, 0], [30, 0, 0], [0, 0, 6.5]])
    tolerance = 1e-4 if backend == "glsl" else 1e-12
    options: dict[str, Any] = {"backend": backend, "dtype": "f32"} if backend == "glsl" else {}

    def of(name: str, where: Any) -> Any:
        return design.field(name, **options)(where)

    np.testing.assert_allclose(of("s_", q), affine(q), atol=tolerance * 20)
    np.testing.assert_array_equal(of("s_", far), -100)
    np.testing.assert_allclose(of("u_", q), q, atol=tolerance)
    np.testing.assert_allclose(of("t_", q), tensor(q)[:, [0, 4, 5]], atol=tolerance * 2)
    np.testing.assert_array_equal(of("t_", far), [[7, 0, 0]] * 3)
    assert len(design.mesh("part", voxel=0.5).faces) > 1000


def test_numbers_in_a_place_are_counted(tmp_path: Path) -> None:
    shutil.copy(DATA / "ascii.vtu", tmp_path / "s.vtu")
    for call, name, instead in (("load", "slope", "load_vector"), ("load_vector", "stress", "load_tensor"),
                                ("load_tensor", "von_mises", "load"), ("load", "stress9", "load_tensor")):  # fmt: skip
        text = f'let t = {call}("s.vtu", "{name}")\nout o = {"t.xx" if "tensor" in call else "t"}'
        made = program(tmp_path, text)
        with pytest.raises(PoreError) as error:
            made.field("o")
        assert error.value.diagnostics[0].code == "E133"
        assert f"`{instead}` takes" in error.value.diagnostics[0].hint


@pytest.mark.parametrize(
    ("unit", "scale", "dimension"),
    [
        ("MPa", 1.0, "a stress"), ("Pa", 1e-6, "a stress"), ("1GPa", 1e3, "a stress"), ('"kPa"', 1e-3, "a stress"),
        ("N/mm^2", 1.0, "a stress"), ("N / m^2", 1e-6, "a stress"), ("6.894757kPa", 6.894757e-3, "a stress"),
        ("m", 1e3, "a length"), ("cm", 10.0, "a length"), ('"%"', 0.01, "a ratio"), ("psi", 1.0, "a force"),
    ],
)  # fmt: skip
def test_values_are_in_the_unit_that_is_named(unit: str, scale: float, dimension: str, tmp_path: Path) -> None:
    """A name of the program that is called like a unit means something else elsewhere."""
    np.savez(tmp_path / "a.npz", s=VALUES, origin=[0, 0, 0], spacing=1)
    lets = "let psi = 1N\nlet m = 7deg\nlet used = m\n"
    made = program(tmp_path, f'{lets}out s = load("a.npz", "s", unit={unit})\nout v = load("a.npz", "s")')
    assert str(made.outputs["s"].value.dimension) == dimension  # type: ignore[union-attr]  # a number
    q = np.random.default_rng(1).uniform(0, 3, (50, 3))
    np.testing.assert_allclose(made.field("s")(q), scale * made.field("v")(q), rtol=1e-15)


def test_units_of_loaded_fields_are_checked(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "a.npz", s=VALUES, v=np.ones((2, 2, 2, 3)), t=np.ones((2, 2, 2, 6)), origin=[0, 0, 0], spacing=1
    )
    for text, code in (
        ('load("a.npz", "s", unit=MPa) + 1mm', "E062"), ('load("a.npz", "s", unit=MPa, outside=1mm)', "E062"),
        ('load_vector("a.npz", "v", unit=mm) + [1deg, 0, 0]', "E062"), ('load("a.npz", "s", unit=x * 1mm)', "E063"),
        ('load_tensor("a.npz", "t", unit=MPa).xy + 1N', "E062"), ('load("a.npz", "s", unit=-1MPa)', "E153"),
    ):  # fmt: skip
        with pytest.raises(PoreError) as error:
            program(tmp_path, text)
        assert [d.code for d in error.value.diagnostics] == [code]
    made = program(tmp_path, 'out s = load("a.npz", "s", unit=kPa, outside=2MPa)')
    assert made.field("s")([[-1.0, 0, 0]])[0] == 2


def test_what_sampling_came_to_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points, tetrahedra = kuhn(6, 12.0)
    rng = np.random.default_rng(4)
    noise = rng.random(len(points))
    write(tmp_path / "a.vtu", points, "tetra", tetrahedra, s=points[:, 0] ** 2, noise=noise)
    write(tmp_path / "m.vtu", points / 1000, "tetra", tetrahedra, s=points[:, 0])
    made = program(tmp_path, 'out a = load("a.vtu", "s") + x')
    (note,) = made.notes()
    grid = read_grid(str(tmp_path / "a.vtu"), "s")
    assert note.message == f"load: {raster.Got.of(grid).told(grid, 1)}"
    assert "1,296 cells from (-6, -6, -6) to (6, 6, 6) mm" in note.message
    assert note.span is not None
    assert note.span.text == 'load("a.vtu", "s")'
    with pytest.warns(porelang.PoreWarning) as told_of:
        program(tmp_path, 'out a = load("a.vtu", "noise", voxel=1.7mm)').notes()
    assert [w.message.diagnostic.code for w in told_of] == ["W230"]  # type: ignore[union-attr]
    voxel = re.search(r"`voxel=([\d.]+)mm`", told_of[0].message.diagnostic.hint)  # type: ignore[union-attr]
    assert voxel is not None
    text = f'out a = load("a.vtu", "noise", voxel={voxel[1]}mm)'
    assert raster.Got.of(read_grid(str(tmp_path / "a.vtu"), "noise", voxel=float(voxel[1]))).share < 0.2
    assert program(tmp_path, text).notes()
    with pytest.warns(porelang.PoreWarning, match="in metres"):
        program(tmp_path, 'out a = load("m.vtu", "s")').notes()
    for text in ('load("m.vtu", "s") @ (p / 1000)', 'load("m.vtu", "s", lengths=m)'):
        mended = program(tmp_path, f"out a = {text}")
        np.testing.assert_allclose(mended.field("a")([[3.0, 1, 2]]), 3 if "@" in text else 3e-3 * 1e3, rtol=1e-9)
        assert len(mended.notes()) == 1
    np.savez(tmp_path / "a.npz", s=VALUES, origin=[0, 0, 0], spacing=1)
    (note,) = program(tmp_path, 'out s = load("a.npz", "s")').notes()
    assert note.message.endswith("nodes from (0, 0, 0) to (3, 4, 5) mm")
    assert porelang.cli.main(["check", str(tmp_path / "part.pore")]) == 0
    (tmp_path / "part.pore").write_text(f'out a = load("{tmp_path}/a.vtu", "s") & cube(5)')
    capsys.readouterr()
    assert porelang.cli.main(["check", str(tmp_path / "part.pore")]) == 0
    assert "sampled every" in "".join(capsys.readouterr())
