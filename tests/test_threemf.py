"""Parts as functions in 3MF files: valid, read by lib3mf, and what they give is what the program gives."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from threemf_reader import CORE, I, Package, V, evaluate, level_set

import porelang
from porelang.analysis.enclose import F64
from porelang.backends.error import judge
from porelang.backends.implicit import NODES, Unwritable, function
from porelang.cli import main
from porelang.conformance.law import places
from porelang.diagnostics import PoreError
from porelang.formula import Formula
from porelang.interval import Interval
from porelang.ir import order, within
from porelang.ops import TABLE
from porelang.threemf.field import write_field

ROOT = Path(__file__).parent.parent
SCHEMAS = Path(__file__).parent / "data" / "3mf"
COUNT = 4000


def around(reach: float) -> list[Interval]:
    return [Interval(np.array([-reach]), np.array([reach]), np.array([False]))] * 3


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(f'<r xmlns:i="{I[1:-1]}">{text}</r>')[0]


def prelude_examples() -> list[str]:
    texts = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "porelang" / "prelude").glob("*.pore"))]
    return [e for text in texts for e in re.findall(r"^## Example: (.*)$", text, re.MULTILINE)]


def agrees(formula: Formula, reach: float = 50.0, seed: int = 1) -> None:
    """The function of a formula keeps the law that backends are held to, at thousands of points."""
    points = places(COUNT, seed, reach)
    made = function(formula, around(reach), '"f"')
    got = evaluate(parsed(made.text), points)
    with np.errstate(all="ignore"):
        verdict = judge(formula, points, got, F64)
    # where the source may be no number or infinite the function is any number
    real = ~verdict.allowed.nan & np.isfinite(verdict.allowed.lo) & np.isfinite(verdict.allowed.hi)
    assert real.mean() > 0.4
    broken = np.argwhere(verdict.broken & real).ravel()
    assert not len(broken), (points[broken[0]], got[broken[0]], verdict.allowed.lo[broken[0]], len(broken))


@pytest.mark.parametrize("text", prelude_examples())
def test_prelude_gives_what_numpy_gives(text: str) -> None:
    program = porelang.compile(text)
    for root in program.roots():
        formula = program.design().formula(root)
        if {n.op for n in order([root], within)} & NOT_WRITTEN:
            with pytest.raises(Unwritable):
                function(formula, around(50.0), '"f"')
        else:
            agrees(formula)


NOT_WRITTEN = {"random", "sites", "nearest", "joined", "principal", "lookup_cubic"}


def test_every_operation_is_written_or_refused() -> None:
    assert set(TABLE) == set(NODES) | NOT_WRITTEN | {"lookup", "covers"}
    assert not set(NODES) & NOT_WRITTEN


#: What forms are made of again: arguments where an operation may jump, is undefined, or is made of others.
HARD = [
    "round(x / 2)", "round(x + 0.49999999999999994)", "x % 3", "x % -3", "mod(x, y)", "sign(floor(x))", "atan2(y, x)",
    "atan2(x, -3)", "atan2(y, 0)", "asin(x / 50)", "acos(x / 50)", "abs(x) ^ 0.5", "x ^ 3", "x ^ 2", "x ^ -1", "x ^ -2",
    "abs(x) ^ (y / 9)", "2 ^ x", "x / y", "min(1 / x, 5)", "sqrt(x)", "exp(-x)", "log(x)", "max(log(x), -3)",
    "if x < y then x else z", "if x <= y and not (z == x) then x else y", "if x == 3 or y == z then 1 else 2",
    "if x <= y then 1 else 2",
    "sin(x)", "cos(x)", "sin(y * 360deg)", "if x > 0 then sqrt(x) else 0 - x", "if x == 0 then 1 else sin(x) / x",
    "hypot(x, y)", "length(p)", "grad(length(p) * atan2(y, x)).x", "grad(acos(z / length(p))).y",
]  # fmt: skip


@pytest.mark.parametrize("text", HARD)
def test_operation_gives_what_numpy_gives(text: str) -> None:
    for seed in (1, 2):
        agrees(porelang.compile(text).design().of(), seed=seed)


@pytest.mark.parametrize("text", HARD)
def test_no_node_is_undefined(text: str) -> None:
    """What no branch reads is a number too: readers may compute both sides of a `select`, or give up at a NaN."""
    formula = porelang.compile(text).design().of()
    made = function(formula, around(50.0), '"f"')
    lines = made.text.splitlines()
    points = np.concatenate([places(COUNT, 3), np.zeros((1, 3))])
    for line in lines[2:-1]:
        port = "value" if "<i:constant " in line else "result"
        if "<i:vector identifier" in line:
            continue
        (name,) = re.findall(r'<i:\w+ identifier="(n\d+)"', line)
        end = f'<i:out><i:scalarref identifier="shape" ref="{name}.{port}"/></i:out></i:implicitfunction>'
        values = evaluate(parsed("\n".join([*lines[:-1], end])), points)
        assert not np.isnan(values).any(), line


@pytest.mark.parametrize(
    "path", sorted((ROOT / "examples").glob("*.pore")) + sorted((ROOT / "examples" / "figures").glob("*.pore")), ids=str
)
def test_examples_give_what_numpy_gives(path: Path) -> None:
    """Those that read data have a tolerance of their own: `test_image_...`."""
    program = porelang.compile(path=path)
    for name in program.outputs:
        if not {n.op for n in order([program.solid(name)], within)} & {*NOT_WRITTEN, "lookup"}:
            agrees(program.design().of(name), 30.0)


def test_settings_are_constants(tmp_path: Path) -> None:
    program = porelang.compile("param r = 5mm in 1mm..9mm\nparam f = sphere in {sphere, cube}\nf(r)")
    write_field(program.design(r=7.5, f="cube"), tmp_path / "a.3mf")
    points = places(COUNT, 4, 10)
    values = level_set(Package.read(tmp_path / "a.3mf"), points)
    np.testing.assert_allclose(values, program.field(r=7.5, f="cube", dtype="f64")(points), atol=1e-13)


BODY = "let body = box([20, 16, 12]) |> translate([3, -2, 1])\n"


@pytest.mark.parametrize("field", ["3 * x + y * z / 4", "hypot(x, y) - 6", "gyroid(9) |> shell(0.5)"])
def test_image_gives_what_its_samples_give(field: str, tmp_path: Path) -> None:
    """Within half a step of 16 bits, in the box and far beyond it, where samples are held."""
    program = porelang.compile(f"{BODY}out part = body & sample({field}, 1mm, body)")
    found = write_field(program.design(), tmp_path / "a.3mf")
    (image,) = found["images"]
    points = places(COUNT, 5, 15)
    got = level_set(Package.read(tmp_path / "a.3mf"), points)
    wanted = program.field("part", dtype="f64")(points)
    assert image["error"] < 1e-3
    np.testing.assert_allclose(got, wanted, atol=image["error"] * 1.001 + 1e-12)
    assert np.abs(got - wanted).max() > image["error"] / 100  # the error that is stated is not far from the truth


def test_images_of_a_vector_and_of_nothing_new(tmp_path: Path) -> None:
    """Each component is an image, of what is the same everywhere none, and one that is read twice is there once."""
    text = "let v = sample([x, 4, z], 2mm, body)\nout part = body & (v.x + v.y * v.z + (v.x @ (2 * p)) - 5)"
    program = porelang.compile(BODY + text)
    found = write_field(program.design(), tmp_path / "a.3mf")
    assert len(found["images"]) == 2
    points = places(COUNT, 6, 15)
    got = level_set(Package.read(tmp_path / "a.3mf"), points)
    room = sum(i["error"] for i in found["images"]) * 5
    np.testing.assert_allclose(got, program.field("part", dtype="f64")(points), atol=room)


@pytest.mark.parametrize("name", ["bending", "hole", pytest.param("grip", marks=pytest.mark.slow)])
def test_example_with_data_is_written(name: str, tmp_path: Path) -> None:
    program = porelang.compile(path=ROOT / "examples" / f"{name}.pore")
    found = write_field(program.design(), tmp_path / "a.3mf", name="part")
    lo, hi = np.array(found["lo"]), np.array(found["hi"])
    points = np.random.default_rng(7).uniform(lo, hi, (COUNT, 3))
    got = level_set(Package.read(tmp_path / "a.3mf"), points)
    wanted = program.field("part", dtype="f64")(points)
    spans = [i["error"] * 2 * 65535 for i in found["images"]]
    assert np.abs(got - wanted).max() < 1e-4 * max(1.0, *spans)
    assert ((got < 0) == (wanted < 0)).mean() > 0.999


def test_box_of_the_part_or_the_bounds(tmp_path: Path) -> None:
    program = porelang.compile("sphere(8)")
    free = write_field(program.design(), tmp_path / "a.3mf")
    assert free["lo"] == [-8.25] * 3
    cut = write_field(program.design(), tmp_path / "a.3mf", bounds=(1, 1, 1, 9, 9, 5))
    assert (cut["lo"], cut["hi"]) == ([1, 1, 1], [9, 9, 5])
    package = Package.read(tmp_path / "a.3mf")
    (shape,) = package.built()
    assert (shape.get("meshbboxonly"), shape.get("channel")) == ("true", "shape")
    mesh = trimesh_of(package, shape.attrib["meshid"])
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(8 * 8 * 4)
    np.testing.assert_array_equal(mesh.bounds, [[1, 1, 1], [9, 9, 5]])


def trimesh_of(package: Package, number: str) -> trimesh.Trimesh:
    (mesh,) = package.resource(number)
    vertices = [[float(v.attrib[a]) for a in "xyz"] for v in mesh.iter(f"{CORE}vertex")]
    faces = [[int(t.attrib[a]) for a in ("v1", "v2", "v3")] for t in mesh.iter(f"{CORE}triangle")]
    return trimesh.Trimesh(vertices, faces, process=False)


def written(tmp_path: Path, text: str) -> Path:
    write_field(porelang.compile(text).design(), tmp_path / "a.3mf")
    return tmp_path / "a.3mf"


SUM = f"{BODY}body & ({' + '.join(f'(if ({t}) < 1 then 1 else 2)' for t in HARD)} - 99"
ALL = f"{SUM} + sample(x * y, 2mm, body))"


#: Where the schemas of version 0.8.0 contradict the text of the specification, its examples and lib3mf: what stands
#: there, what is meant, and how often.
SLIPS = (
    ("2147483647", "unbounded", None),  # libxml2 counts no further than its own integers
    ('elementFormDefault="unqualified"', 'elementFormDefault="qualified"', 1),  # ports are written as `i:in`, `i:out`
    ('Output" />\n\t\t\t\t\t<xs:any', 'Output" />\n\t\t\t\t\t<xs:any minOccurs="0"', 1),  # nothing has to follow
    ('<xs:element ref="resourceid" />\n\t\t\t<xs:element ref="mod"',
     '<xs:element ref="constresourceid" />\n\t\t\t<xs:element ref="mod"', 1),  # so it is called below
)  # fmt: skip


def test_schemas_hold(tmp_path: Path) -> None:
    """All that is of the extensions in a file that has every node, by their schemas without their slips."""
    etree = pytest.importorskip("lxml.etree")
    text = (SCHEMAS / "implicit.xsd").read_text(encoding="utf-8")
    for wrong, right, count in SLIPS:
        assert text.count(wrong) == (count or text.count(wrong)) > 0, wrong
        text = text.replace(wrong, right)
    for of_one in ("Abs", "Sqrt"):  # which read two numbers there
        form = rf'(<xs:complexType name="CT_{of_one}">.*?<xs:element name="out")'
        before, inputs, after = re.split(form, text, flags=re.DOTALL)
        text = before + inputs.replace('Occurs="2"', 'Occurs="1"') + after
    other = (SCHEMAS / "volumetric.xsd").read_text(encoding="utf-8").replace(*SLIPS[0][:2])
    (tmp_path / "volumetric.xsd").write_text(other, encoding="utf-8")
    (tmp_path / "implicit.xsd").write_text(text, encoding="utf-8")
    schemas = {space: etree.XMLSchema(file=str(tmp_path / f"{name}.xsd")) for space, name in (
        (V, "volumetric"), (I, "implicit"),
    )}  # fmt: skip
    package = Package.read(written(tmp_path, ALL))
    model = etree.fromstring(package.parts["3D/3dmodel.model"])
    seen = set()
    for element in [e for e in model.iter() if e.getparent() is not None]:
        space = element.tag.partition("}")[0] + "}"
        if space in schemas and not element.getparent().tag.startswith(space):
            seen.add(element.tag)
            schemas[space].assertValid(element)
    assert seen == {f"{V}image3d", f"{V}functionfromimage3d", f"{V}levelset", f"{I}implicitfunction"}
    nodes = {e.tag.removeprefix(I) for e in package.model.iter() if e.tag.startswith(I)}
    forms = set(re.findall(r"'([a-z0-9]{3,})'", repr([(f.nodes, f.plain) for f in NODES.values()])))
    assert forms <= nodes  # every kind of node is in it


def test_lib3mf_reads_all_of_it(tmp_path: Path) -> None:
    """The consortium's own reader, which keeps silent about nodes that it does not know, has every node and link."""
    lib3mf = pytest.importorskip("lib3mf")
    for text, strict in ((f"{SUM})", True), (ALL, False)):
        path = written(tmp_path, text)
        package = Package.read(path)
        wrapper = lib3mf.get_wrapper()
        model = wrapper.CreateModel()
        reader = model.QueryReader("3mf")
        reader.SetStrictModeActive(strict)
        reader.ReadFromFile(str(path))
        told = [reader.GetWarning(i) for i in range(reader.GetWarningCount())]
        # 2.5 warns of each image as an element that it does not know, and reads it (a missing `else` in its resources)
        assert [str(t[-1]) for t in told] == ["Invalid Element in namespace."] * (0 if strict else 2)
        (shape,) = package.built()
        sets = model.GetLevelSets()
        assert sets.MoveNext()
        found = sets.GetCurrentLevelSet()
        assert (found.GetChannelName(), found.GetMeshBBoxOnly(), found.GetFallBackValue()) == ("shape", True, 1.0)
        assert found.GetMesh().GetVertexCount() == 8
        function = model.GetResourceByID(found.GetFunction().GetUniqueResourceID())
        own = package.resource(shape.attrib["functionid"])
        nodes, read = function.GetNodes(), 0
        while nodes.MoveNext():
            node = nodes.GetCurrent()
            read += 1
            ports = node.GetInputs()
            links = {}
            while ports.MoveNext():
                port = ports.GetCurrent()
                links[port.GetIdentifier()] = port.GetReference()
            (same,) = (e for e in own if e.get("identifier") == node.GetIdentifier())
            assert links == {p.attrib["identifier"]: p.attrib["ref"] for e in same if e.tag == f"{I}in" for p in e}
        assert read == len(own) - 2


@pytest.mark.parametrize(
    ("text", "what", "place", "way"),
    [
        ("let w = voronoi_cells(8mm, 1mm)\nout part = w & cube(20)", "random sites",
         "voronoi_cells(8mm, 1mm)", "sample(voronoi_cells(8mm, 1mm), 1mm, body)"),
        ("cube(20) & (perlin(5mm) + 0.1)", "noise", "perlin(5mm)", "sample(perlin(5mm), 1mm, body)"),
        ('truss("octet", 9mm, 1mm) & cube(20)', "the nearest bar", 'truss("octet", 9mm, 1mm)', "--beams"),
        ('truss("octet", 9mm, 1mm, joint=1mm) & cube(20)', "bars that are joined", None, "sample("),
        ("let b = cube(20)\nout part = b & sample(x, 1mm, b, smooth=true)", "samples with a smooth gradient",
         "sample(x, 1mm, b, smooth=true)", "leave out `smooth=true`"),
        ("let b = cube(20)\nlet s = sample(x * y, 1mm, b)\nout part = b & (s / length(grad(s)))",
         "the gradient of samples", "grad(s)", "sample(grad(s), 1mm, body)"),
    ],
)  # fmt: skip
def test_what_no_function_says_is_refused(text: str, what: str, place: str | None, way: str, tmp_path: Path) -> None:
    design = porelang.compile(text).design()
    with pytest.raises(PoreError) as error:
        write_field(design, tmp_path / "a.3mf", name="part")
    (found,) = error.value.diagnostics
    assert (found.code, found.message) == ("E197", f"{what}: no function of 3MF can say that")
    assert found.span is not None
    assert place is None or found.span.text == place
    assert way in found.hint
    assert not list(tmp_path.iterdir())


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.pore").write_text("param r = 5mm in 1mm..9mm\nout part = sphere(r)\nout two = sphere(2 * r)")
    assert main(["volume", "a.pore", "-o", "a.3mf", "--out", "two", "--set", "r=3mm", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    package = Package.read(Path("a.3mf"))
    (shape,) = package.built()
    assert told["nodes"] == len(package.resource(shape.attrib["functionid"])) - 2
    assert told["bytes"] == Path("a.3mf").stat().st_size
    assert level_set(package, np.array([[6.5, 0, 0]])) == pytest.approx([0.5])
    notes = {m.attrib["name"]: m.text for m in package.model.iter(f"{CORE}metadata")}
    assert (notes["pore:param.r"], notes["pore:output"]) == ("3.0", "two")
    first = Path("a.3mf").read_bytes()
    assert main(["volume", "a.pore", "-o", "a.3mf", "--out", "two", "--set", "r=3mm"]) == 0
    assert "two as a function of" in capsys.readouterr().out
    assert Path("a.3mf").read_bytes() == first
    for more in (["--voxel", "1mm"], ["--resolution", "9"], ["--field", "two"], ["--dtype", "f64"]):
        assert main(["volume", "a.pore", "-o", "a.3mf", "--out", "two", *more]) == 2
        assert f"it takes no {more[0]}" in capsys.readouterr().err
