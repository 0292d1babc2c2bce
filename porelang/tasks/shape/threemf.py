"""The triangles of a .3mf file, by the 3MF Core Specification 1.3: what its build lists, where that puts it.

A .3mf is a ZIP archive of XML. Objects are meshes, or components: other objects, moved; those of the production
extension may lie in other files of the archive. What else there is (colours, beams, slices) is left out.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, field
from typing import IO, Any
from xml.etree import ElementTree

import numpy as np

from porelang.tasks.shape.file import LARGEST, UnusableError, check_count
from porelang.tasks.shape.mend import Faces, Points

#: In mm; the specification's default is the millimetre.
UNITS = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
#: Types of objects that are no part of the model: what holds it up in the printer, and what is there for other use.
ASIDE = ("support", "other")
_RELATIONS, _MODEL = "_rels/.rels", "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_DEEPEST = 64  # components in components
_MOST_ITEMS = 100_000

Placed = tuple[str, str, Points]  # the file of an object, its id, and a transform (4, 3)


@dataclass
class _Object:
    corners: list[tuple[float, float, float]] = field(default_factory=list)
    triangles: list[tuple[int, int, int]] = field(default_factory=list)
    parts: list[Placed] = field(default_factory=list)
    aside: bool = False


@dataclass
class _Model:
    unit: float = 1.0
    objects: dict[str, _Object] = field(default_factory=dict)
    items: list[Placed] = field(default_factory=list)


def triangles_of(file: IO[bytes]) -> tuple[Points, Faces, float]:
    """Corners (n, 3) and triangles (m, 3) of a file, and its unit in mm. Errors: UnusableError, and any of the reader's
    own where the file is damaged."""
    models: dict[str, _Model] = {}
    with zipfile.ZipFile(file) as archive:
        first = _named(archive)

        def model(path: str) -> _Model:
            if path not in models:
                models[path] = _read(archive, path)
            return models[path]

        corners: list[Points] = []
        faces: list[Faces] = []
        count = items = 0
        waiting = [(*item, 0) for item in model(first).items]
        while waiting:
            path, name, placed, depth = waiting.pop()
            items += 1
            if depth > _DEEPEST or items > _MOST_ITEMS:
                raise UnusableError("E140", "is damaged: its components have no end", "export it again")
            found = model(path).objects.get(name)
            if found is None:
                raise ValueError(f"there is no object {name[:40]}")
            waiting += [(at, part, _joined(moved, placed), depth + 1) for at, part, moved in found.parts]
            if found.triangles and not found.aside:
                here = np.array(found.corners, np.float64).reshape(-1, 3)
                triangles = np.array(found.triangles, np.int64)
                if triangles.min() < 0 or triangles.max() >= len(here):
                    raise ValueError(f"a triangle names corner {triangles.max():,} of {len(here):,}")
                if np.linalg.det(placed[:3]) < 0:  # a mirror image is turned inside out
                    triangles = triangles[:, ::-1]
                corners.append(here @ placed[:3] + placed[3])
                faces.append(triangles + count)
                count += len(here)
                check_count(sum(map(len, faces)))
    if not faces:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64), models[first].unit
    return np.concatenate(corners), np.concatenate(faces), models[first].unit


def _named(archive: zipfile.ZipFile) -> str:
    """The file of the archive that its relations name as the model, by the Open Packaging Conventions."""
    for relation in ElementTree.fromstring(_text(archive, _RELATIONS)):
        if relation.get("Type") == _MODEL:
            return relation.get("Target", "").lstrip("/")
    raise ValueError("it names no model")


def _text(archive: zipfile.ZipFile, path: str) -> bytes:
    about = archive.getinfo(path)
    if about.file_size > LARGEST:
        raise UnusableError("E135", f"is too large: {about.file_size:,} bytes of {LARGEST:,}", "simplify the mesh")
    return archive.read(about)


def _read(archive: zipfile.ZipFile, path: str) -> _Model:
    made, current = _Model(), _Object()
    text = _text(archive, path)
    if b"<!DOCTYPE" in text:  # whose entities may be a billion
        raise ValueError("it has a DOCTYPE, which a model has not")
    parser: Any = ElementTree.XMLPullParser(("start", "end"))
    for start in range(0, len(text), 1 << 20):
        parser.feed(text[start : start + (1 << 20)])
        for event, element in parser.read_events():
            tag = str(element.tag).rpartition("}")[2]
            if event == "start":
                if tag == "model":
                    made.unit = _unit(element.get("unit", "millimeter"))
                elif tag == "object":
                    current = made.objects[element.get("id", "")] = _Object(aside=element.get("type") in ASIDE)
                continue
            match tag:
                case "vertex":
                    current.corners.append((float(element.get("x", "")), float(element.get("y", "")),
                                            float(element.get("z", ""))))  # fmt: skip
                case "triangle":
                    current.triangles.append((int(element.get("v1", "")), int(element.get("v2", "")),
                                              int(element.get("v3", ""))))  # fmt: skip
                case "component":
                    current.parts.append(_placed(element, path))
                case "item":
                    made.items.append(_placed(element, path))
                case "vertices" | "triangles" | "object":
                    element.clear()
                case _:
                    pass
    parser.close()
    return made


def _unit(name: str) -> float:
    if name not in UNITS:
        raise UnusableError("E140", f"is in `{name[:40]}`, which is no unit of a .3mf file",
                            f"a unit of it is one of {', '.join(UNITS)}")  # fmt: skip
    return UNITS[name]


def _placed(element: Any, path: str) -> Placed:
    elsewhere = next((value for name, value in element.attrib.items() if name.rpartition("}")[2] == "path"), path)
    numbers = [float(n) for n in element.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()]
    return str(elsewhere).lstrip("/"), element.get("objectid", ""), np.array(numbers).reshape(4, 3)


def _joined(inner: Points, outer: Points) -> Points:
    """One transform after another, of rows."""
    out: Points = inner @ outer[:3]
    out[3] += outer[3]
    return out
