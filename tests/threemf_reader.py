"""A reader of 3MF functions and bars that knows the formats from their specifications alone, in float64.

3MF Volumetric & Implicit Extensions 0.8.0, 3MF Beam Lattice Extension 1.2.0 (github.com/3MFConsortium).
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Floats = NDArray[np.float64]
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
V = "{http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01}"
I = "{http://schemas.3mf.io/3dmanufacturing/implicit/2023/12}"  # noqa: E741  as the specification calls it
TEXTURE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"

TYPES = {"scalarref": "scalar", "vectorref": "vector", "resourceref": "resourceid"}
#: Nodes of scalars by what they give, of the table in Part II, chapter 5.
SCALARS: dict[str, Callable[..., Any]] = {
    "addition": lambda a, b: a + b,
    "subtraction": lambda a, b: a - b,
    "multiplication": lambda a, b: a * b,
    "division": lambda a, b: a / b,
    "sin": np.sin,
    "cos": np.cos,
    "min": np.minimum,
    "max": np.maximum,
    "abs": np.abs,
    "mod": lambda a, b: a - b * np.floor(a / b),
    "pow": np.power,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "select": lambda a, b, c, d: np.where(a < b, c, d),
    "floor": np.floor,
    "sign": np.sign,
}


@dataclass(frozen=True)
class Package:
    """The parts of a 3MF package, and its model."""

    parts: dict[str, bytes]
    model: ElementTree.Element

    @classmethod
    def read(cls, path: Path) -> Package:
        with zipfile.ZipFile(path) as file:
            parts = {name: file.read(name) for name in file.namelist()}
        return cls(parts, ElementTree.fromstring(parts["3D/3dmodel.model"]))

    def resources(self) -> list[ElementTree.Element]:
        (found,) = self.model.iter(f"{CORE}resources")
        return list(found)

    def resource(self, number: str) -> ElementTree.Element:
        (found,) = (r for r in self.resources() if r.get("id") == number)
        return found

    def built(self) -> ElementTree.Element:
        (item,) = self.model.iter(f"{CORE}item")
        return self.resource(item.attrib["objectid"])


def level_set(package: Package, points: Floats) -> Floats:
    """The values of the level set that a package builds."""
    (found,) = package.built()
    assert found.tag == f"{V}levelset"
    values = evaluate(package.resource(found.attrib["functionid"]), points, package)
    return np.where(np.isfinite(values), values, float(found.attrib["fallbackvalue"]))


def evaluate(function: ElementTree.Element, points: Floats, package: Package | None = None) -> Floats:
    """The output `shape` of an implicit function at points (n, 3). A node that is referred to before it stands there,
    twice, or of another type, is a KeyError or an AssertionError."""
    assert function.tag == f"{I}implicitfunction"
    head, *nodes, end = function
    assert [(p.tag, p.get("identifier")) for p in head] == [(f"{I}vector", "pos")]
    known: dict[tuple[str, str], Any] = {("vector", "inputs.pos"): points}
    with np.errstate(all="ignore"):
        for node in nodes:
            kind, name = node.tag.removeprefix(I), node.attrib["identifier"]
            inputs, outputs = _ports(node)
            read = {p.attrib["identifier"]: known[TYPES[p.tag.removeprefix(I)], p.attrib["ref"]] for p in inputs}
            given = _given(kind, node, read, package)
            assert list(given) == [(p.tag.removeprefix(I), p.attrib["identifier"]) for p in outputs], node.attrib
            for (of, port), value in given.items():
                assert (of, f"{name}.{port}") not in known
                known[of, f"{name}.{port}"] = value
    (shape,) = end
    assert (end.tag, shape.tag, shape.get("identifier")) == (f"{I}out", f"{I}scalarref", "shape")
    return np.broadcast_to(known["scalar", shape.attrib["ref"]], len(points)).astype(np.float64)


def _ports(node: ElementTree.Element) -> tuple[list[ElementTree.Element], list[ElementTree.Element]]:
    return [p for e in node if e.tag == f"{I}in" for p in e], [p for e in node if e.tag == f"{I}out" for p in e]


def _given(
    kind: str, node: ElementTree.Element, read: dict[str, Any], package: Package | None
) -> dict[tuple[str, str], Any]:
    match kind:
        case "constant":
            return {("scalar", "value"): float(node.attrib["value"])}
        case "constresourceid":
            return {("resourceid", "value"): node.attrib["value"]}
        case "composevector":
            return {("vector", "result"): np.stack(np.broadcast_arrays(*(read[a] for a in "xyz")), axis=-1)}
        case "decomposevector":
            return {("scalar", a): read["A"][..., k] for k, a in enumerate("xyz")}
        case "length":
            return {("scalar", "result"): np.sqrt((read["A"] ** 2).sum(axis=-1))}
        case "functioncall":
            assert package is not None
            found = package.resource(read["functionID"])
            return {("scalar", "red"): sampled(found, read["pos"], package)}
    ports = ("A", "B", "C", "D")[: len(read)]
    return {("scalar", "result"): SCALARS[kind](*(read[p] for p in ports))}


def sampled(function: ElementTree.Element, uvw: Floats, package: Package) -> Floats:
    """The red of a `functionfromimage3d`, 0 to 1, at places whose (0, 0, 0) is the corner at the left, in front and
    below, and (1, 1, 1) the one opposite (Part I, chapters 2.2 and 3.2): voxels have their values in their middles."""
    assert (function.tag, function.get("filter", "linear")) == (f"{V}functionfromimage3d", "linear")
    assert {function.get(f"tilestyle{a}") for a in "uvw"} == {"clamp"}
    grey = _stack(package.resource(function.attrib["image3did"]), package)
    at = np.clip(uvw, 0, 1)
    sheets, rows, columns = grey.shape
    place = [at[:, 2] * sheets - 0.5, (1 - at[:, 1]) * rows - 0.5, at[:, 0] * columns - 0.5]  # v goes up, rows down
    value = np.zeros(len(at))
    cells = [np.floor(p) for p in place]
    for corner in range(8):
        weight, index = np.ones(len(at)), []
        for axis, (p, cell, count) in enumerate(zip(place, cells, grey.shape, strict=True)):
            beyond = corner >> axis & 1
            weight = weight * np.where(beyond, p - cell, 1 - (p - cell))
            index.append(np.clip(cell + beyond, 0, count - 1).astype(int))
        value += weight * grey[tuple(index)]
    return value


def _stack(image: ElementTree.Element, package: Package) -> Floats:
    (stack,) = image
    names = [sheet.attrib["path"].removeprefix("/") for sheet in stack]
    linked = {
        e.attrib["Target"].removeprefix("/")
        for e in ElementTree.fromstring(package.parts["3D/_rels/3dmodel.model.rels"])
        if e.attrib["Type"] == TEXTURE
    }
    assert set(names) <= linked
    sheets = []
    for name in names:
        picture = Image.open(io.BytesIO(package.parts[name]))
        assert picture.mode.startswith("I")  # 16 bits
        sheets.append(np.asarray(picture, np.float64) / (2**16 - 1))
    found = np.stack(sheets)
    counts = tuple(int(stack.attrib[f"{what}count"]) for what in ("sheet", "row", "column"))
    assert found.shape == counts
    return found


B = "{http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02}"


@dataclass(frozen=True)
class Bars:
    """The bars of the object that a package builds: ends (n, 2, 3), radii (n,), and the triangles (m, 3, 3) inside of
    which they are kept, if any."""

    ends: Floats
    radii: Floats
    clip: Floats | None

    @classmethod
    def read(cls, package: Package) -> Bars:
        (mesh,) = package.built()
        vertices, lattice = mesh
        assert lattice.tag == f"{B}beamlattice"
        assert lattice.get("cap", "sphere") == "sphere"
        assert package.model.get("requiredextensions") == "b"
        places = _places(vertices)
        (beams,) = lattice
        pairs = np.array([[int(b.attrib[v]) for v in ("v1", "v2")] for b in beams])
        radii = np.array([float(b.get("r1", lattice.attrib["radius"])) for b in beams])
        clip = None
        if lattice.get("clippingmode", "none") != "none":
            assert lattice.get("clippingmode") == "inside"
            listed = [r.get("id") for r in package.resources()]
            number = lattice.attrib["clippingmesh"]
            assert listed.index(number) < listed.index(package.built().get("id"))
            (found,) = package.resource(number)
            faces = [[int(t.attrib[v]) for v in ("v1", "v2", "v3")] for t in found[1]]
            clip = _places(found[0])[np.array(faces)]
        ends = places[pairs]
        assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).min() > float(lattice.attrib["minlength"])
        assert len(np.unique(pairs)) == len(places)
        return cls(ends, radii, clip)

    def distance(self, points: Floats) -> Floats:
        """The signed distance from the bars, whose ends are round, not cut."""
        least = np.full(len(points), np.inf)
        for (a, b), r in zip(self.ends, self.radii, strict=True):
            t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            least = np.minimum(least, np.linalg.norm(points - a - t[:, None] * (b - a), axis=1) - r)
        return least


def _places(vertices: ElementTree.Element) -> Floats:
    return np.array([[float(v.attrib[a]) for a in "xyz"] for v in vertices])
