"""3MF, GLB and VTP files, read back by programs and parsers that are not ours."""

from __future__ import annotations

import json
import struct
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
import trimesh

import porelang
from porelang.diagnostics import PoreError
from porelang.mesh import Grid, Surface, extract, write
from porelang.mesh.export import WRITERS
from porelang.mesh.part import notes_of

NOTES = {"program": 'a "quoted" <name> & é.pore', "sha256": "ab" * 32, "param.w": "30.0"}
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


@pytest.fixture(scope="module")
def part() -> Surface:
    """A torus off the origin, so that a swapped axis or sign shows."""
    lo, hi = (-1.0, -8.0, 0.0), (13.0, 6.0, 6.0)
    grid = Grid.cover(lo, hi, 0.5)

    def sample(a, b):
        x, y, z = np.meshgrid(*grid.axes(lo=a, hi=b), indexing="ij")
        return np.hypot(np.hypot(x - 6, y + 1) - 4, z - 3) - 1.7

    return extract(grid, (lo, hi), sample)


def same(vertices, faces, surface, tolerance):
    assert np.array_equal(faces, surface.faces)
    assert np.abs(np.asarray(vertices) - surface.vertices).max() <= tolerance


def test_a_3mf_file_is_a_package_in_millimetres_with_its_notes(part, tmp_path):
    with zipfile.ZipFile(write(part, tmp_path / "part.3mf", NOTES)) as package:
        assert package.testzip() is None
        links = ET.fromstring(package.read("_rels/.rels"))
        target = next(link.get("Target") for link in links if link.get("Type", "").endswith("/3dmodel"))
        ending = target.rpartition(".")[2]
        assert ending in {e.get("Extension") for e in ET.fromstring(package.read("[Content_Types].xml"))}
        model = ET.fromstring(package.read(target.lstrip("/")))
    assert model.get("unit") == "millimeter"
    said = {m.get("name"): m.text for m in model.findall(f"{CORE}metadata")}
    assert said == {"Application": "porelang"} | {f"pore:{name}": text for name, text in NOTES.items()}
    mesh = model.find(f"{CORE}resources/{CORE}object/{CORE}mesh")
    vertices = [[float(v.get(c)) for c in "xyz"] for v in mesh.find(f"{CORE}vertices")]
    faces = [[int(t.get(c)) for c in ("v1", "v2", "v3")] for t in mesh.find(f"{CORE}triangles")]
    same(vertices, faces, part, 1e-10)
    assert trimesh.Trimesh(vertices, faces, process=False).is_watertight
    [item] = model.find(f"{CORE}build")
    assert item.get("objectid") == model.find(f"{CORE}resources/{CORE}object").get("id")


def test_the_same_part_gives_the_same_3mf_file(part, tmp_path):
    one, other = (write(part, tmp_path / name, NOTES).read_bytes() for name in ("a.3mf", "b.3mf"))
    assert one == other


def test_a_glb_file_is_in_metres_and_stands_upright(part, tmp_path):
    path = write(part, tmp_path / "part.glb", NOTES)
    back = trimesh.load(path, force="mesh")  # a scene brought to its world: y up, metres
    assert back.is_watertight
    assert back.volume == pytest.approx(part.volume * 1e-9, rel=1e-5)
    turned = part.vertices[:, [0, 2, 1]] * [1e-3, 1e-3, -1e-3]  # our z is its y; our y points away from the viewer
    assert np.abs(back.bounds - [turned.min(axis=0), turned.max(axis=0)]).max() < 1e-7
    raw = path.read_bytes()
    magic, version, total, length, kind = struct.unpack("<4sIIII", raw[:20])
    assert (magic, version, total, kind) == (b"glTF", 2, len(raw), 0x4E4F534A)
    scene = json.loads(raw[20 : 20 + length])
    assert scene["asset"]["extras"] == NOTES
    start = 20 + length + 8
    assert start % 4 == 0
    vertices = np.frombuffer(raw, "<f4", 3 * len(part.vertices), start).reshape(-1, 3)
    faces = np.frombuffer(raw, "<u4", 3 * len(part.faces), start + scene["bufferViews"][1]["byteOffset"]).reshape(-1, 3)
    same(vertices * 1e3, faces, part, 1e-5)
    box = scene["accessors"][0]
    assert np.array_equal(np.float32([box["min"], box["max"]]), [vertices.min(axis=0), vertices.max(axis=0)])


def test_a_vtp_file_has_its_arrays_where_it_says(part, tmp_path):
    raw = write(part, tmp_path / "part.vtp", NOTES).read_bytes()
    head, mark, data = raw.partition(b'<AppendedData encoding="raw">\n_')
    assert mark
    root = ET.fromstring(head + b"</VTKFile>")
    assert root.attrib == {"type": "PolyData", "version": "1.0", "byte_order": "LittleEndian", "header_type": "UInt64"}
    piece = root.find("PolyData/Piece")
    assert int(piece.get("NumberOfPoints")) == len(part.vertices)
    assert int(piece.get("NumberOfPolys")) == len(part.faces)
    types = {"Float64": "<f8", "Int32": "<i4", "Int64": "<i8"}

    def array(path):
        at = piece.find(path)
        offset = int(at.get("offset"))
        size = struct.unpack_from("<Q", data, offset)[0]
        form = np.dtype(types[at.get("type")])
        return np.frombuffer(data, form, size // form.itemsize, offset + 8)

    same(array("Points/DataArray").reshape(-1, 3), array("Polys/DataArray[1]").reshape(-1, 3), part, 0)
    assert np.array_equal(array("Polys/DataArray[2]"), 3 * np.arange(1, len(part.faces) + 1))
    texts = {a.get("Name"): bytes(map(int, a.text.split()))[:-1].decode() for a in root.find("PolyData/FieldData")}
    assert texts == NOTES


@pytest.mark.parametrize("ending", [".ply", ".obj"])
def test_notes_are_comments_where_a_format_has_no_other_place(part, tmp_path, ending):
    path = write(part, tmp_path / f"part{ending}", NOTES | {"long": "two\nlines"})
    assert len(trimesh.load(path).faces) == len(part.faces)
    text = path.read_bytes()[:2000]
    assert b"param.w 30.0\n" in text
    assert b"long two\\nlines\n" in text


def test_a_name_whose_bytes_are_no_text_is_written_in_plain_letters(part, tmp_path):
    design = porelang.compile("sphere(5)", name="folder/a\udcff.pore").design()
    path = write(part, tmp_path / "part.obj", notes_of(design, None))
    assert b"# program a\\xff.pore\n" in path.read_bytes()[:200]


def test_a_mesh_too_fine_for_32_bits_is_refused_as_glb(part, tmp_path):
    far = Surface(part.vertices * 1e-3 + 1e5, part.faces)
    with pytest.raises(PoreError) as caught:
        write(far, tmp_path / "far.glb")
    assert caught.value.diagnostics[0].code == "E115"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", sorted(WRITERS))
def test_an_interrupted_file_is_no_file(part, tmp_path, monkeypatch, ending):
    whole = WRITERS[ending]

    def half(surface, file, notes):
        whole(surface, file, notes)
        raise KeyboardInterrupt

    monkeypatch.setitem(WRITERS, ending, half)
    with pytest.raises(KeyboardInterrupt):
        write(part, tmp_path / f"part{ending}")
    assert list(tmp_path.iterdir()) == []
