"""Words of other programs: what a name, or a parameter, of OpenSCAD, GLSL, NumPy, Curv or nTop is called in Pore."""

from __future__ import annotations

NO_PREFIX = "functions have no prefix here: `sin(x)`, `sqrt(x)`, `pi`"
_SHOWN = "a program shows nothing while it is read: `pore eval` and `pore measure` tell values, `check` asks for them"
_LOOKS = "a part has no colour of its own: `pore render` draws it"
_STRUTS = 'lattices of bars are read from a file: `frame("bars.json")`; or made of `capsule(a, b, r)`'
MESHES = 'a mesh is read by `mesh("part.stl")`, as a solid'

#: A name that stands for nothing in Pore: what to write in its place, or a pair: the name that may be put
#: there as it is, and how it is called.
NAMES: dict[str, str | tuple[str, str]] = {
    # OpenSCAD and ImplicitCAD
    "difference": "write `a \\ b` for a without b",
    "subtract": "write `a \\ b` for a without b",
    "hull": "there are no hulls: `capsule(a, b, r)` is that of two balls, `smooth_union(a, b, r)` fills a corner",
    "minkowski": "there are no sums of solids: `offset(f, 2mm)` grows a solid by a ball",
    "linear_extrude": ("extrude", "`extrude(profile, h)`: h high, centred on z = 0"),
    "rotate_extrude": ("revolve", "`revolve(profile)`: round the z axis"),
    "cuboid": ("box", "`box([a, b, c])`, centred on the origin"),
    "polyhedron": "intersect half-spaces: `plane([0, 0, 1], 5) & plane([1, 0, 0], 5) & ...`",
    "resize": "`scale(f, s)` scales by a factor, or by three",
    "multmatrix": "write `orient(f, origin, xaxis, yaxis)`",
    "color": _LOOKS,
    "echo": _SHOWN,
    "norm": ("length", "`length(v)`"),
    "children": "a `def` takes a solid as a parameter: `def turned(f) = rotate(f, [0, 0, 1], 45deg)`",
    "import": MESHES,
    "stl": MESHES,
    "undef": "there is no empty value: leave the argument out",
    # signed distances in GLSL
    "smin": ("smooth_union", "`smooth_union(a, b, r)`: r is how far it is rounded, in mm"),
    "smax": ("smooth_intersection", "`smooth_intersection(a, b, r)`: r is how far it is rounded, in mm"),
    "opUnion": "write `a | b`",
    "opSubtraction": "write `b \\ a` for b without a",
    "opIntersection": "write `a & b`",
    "opSmoothUnion": ("smooth_union", "`smooth_union(a, b, r)`"),
    "sdSphere": "write `sphere(r)`, a field of the point",
    "sdBox": "write `box([a, b, c])`, with whole lengths, a field of the point",
    "sdTorus": "write `torus(R, r)`, a field of the point",
    "sdCapsule": "write `capsule(a, b, r)`, a field of the point",
    **dict.fromkeys(("vec2", "vec3", "vec4"), "a vector is written `[a, b, c]`; there are vectors of three only"),
    **dict.fromkeys(("float", "int", "bool"), "numbers need no conversion: leave it out; `floor(a)` is whole"),
    "lerp": ("mix", "`mix(a, b, t)`"),
    "texture": "write `load(\"data.npz\", \"name\")` for a sampled field",
    "rsqrt": ("inversesqrt", "`inversesqrt(a)`"),
    # Python and NumPy
    **dict.fromkeys(("np", "numpy", "math", "Math", "torch", "jnp"), NO_PREFIX),
    **dict.fromkeys(("print", "printf", "console"), _SHOWN),
    **dict.fromkeys(("while", "do", "loop"), "there are no loops: `[for i in range(6): value]` makes a list"),
    "class": "there are no classes: a `def` makes a solid of its parameters",
    "lambda": "a function is written `x => 2 * x`",
    "None": "there is no empty value: leave the argument out",
    "linspace": "write `[for i in range(n): i / (n - 1)]`",
    "arange": ("range", "`range(start, stop, step)`"),
    "enumerate": "write `[for i in range(len(items)): items[i]]`",
    "zip": "write `[for i in range(len(a)): [a[i], b[i]]]`",
    "ln": ("log", "`log(a)`, the natural logarithm"),
    "log10": "write `log(a) / log(10)`",
    "power": "write `a ^ b`, or `pow(a, b)`",
    **dict.fromkeys(("arctan2", "arctan"), ("atan2", "`atan2(y, x)`")),
    "arcsin": ("asin", "`asin(a)`"),
    "arccos": ("acos", "`acos(a)`"),
    "clip": ("clamp", "`clamp(a, lo, hi)`"),
    # Curv, nTop, Grasshopper
    "move": ("translate", "`translate(f, [1, 2, 3])`"),
    "rotated": ("rotate", "`rotate(f, [0, 0, 1], 45deg)`"),
    **dict.fromkeys(("remap", "remap_numbers", "map_range"), "write `mix(lo, hi, ramp(x, a, b))`: a..b becomes lo..hi"),
    **dict.fromkeys(("boolean_union", "unite"), "write `a | b`, or `union([a, b, c])`"),
    **dict.fromkeys(("boolean_subtract",), "write `a \\ b` for a without b"),
    **dict.fromkeys(("boolean_intersect", "intersect"), "write `a & b`, or `intersection([a, b, c])`"),
    **dict.fromkeys(("slider", "number_slider"), "write `param w = 30mm in 10mm..60mm`"),
    **dict.fromkeys(("octet", "bcc", "fcc", "kelvin"), _STRUTS),
    # lattices by their other names
    **dict.fromkeys(("primitive", "schwarz", "schwarzP", "schwarz_primitive"), ("schwarz_p", "`schwarz_p(w)`")),
    **dict.fromkeys(("schwarz_d", "schwarzD", "schwarz_diamond"), ("diamond", "`diamond(w)`")),
    **dict.fromkeys(("fks", "fischer_koch", "FKS"), ("fischer_koch_s", "`fischer_koch_s(w)`")),
}  # fmt: skip

_ROUNDED = "`box`, `cylinder` and others take `round=2mm`; `smooth_union(a, b, r)` fills a corner"
_COPIED = "`repeat(f, w, counts=[4, 4, 1])` copies along the axes, `union([for i in range(6): ...])` in any way"
_LINES = "`pipe(points, r)` is a rod along points, `along(f, points)` bends f along them, `spline(points)` smooths them"
_BUILT_IN = 'it is not there: sample it on a grid elsewhere, and `load("data.npz", "name")` reads it'
#: Words that are functions elsewhere, and here might be any name: what to write where one is called and means nothing.
CALLED: dict[str, str | tuple[str, str]] = {
    **dict.fromkeys(("fillet", "fillets", "rounding"), f"there are no fillets of edges: {_ROUNDED}"),
    **dict.fromkeys(("chamfer", "bevel"), f"there are no chamfers: cut with a `plane(normal, d)`; {_ROUNDED}"),
    **dict.fromkeys(("array", "pattern", "linear_array", "linear_pattern", "rectangular_array", "grid"), _COPIED),
    **dict.fromkeys(("polar_array", "circular_pattern", "polar_pattern", "radial_array"),
                    ("ring", "`ring(f, n)`: n copies round the z axis")),
    **dict.fromkeys(("copy", "duplicate", "clone"), f"a name may be used as often as you like; {_COPIED}"),
    "series": "write `[for i in range(n): start + i * step]`, or `range(start, stop, step)`, which ends before stop",
    "domain": "a range is `lo..hi`, as in `param w = 30mm in 10mm..60mm`; `ramp(x, lo, hi)` runs from 0 to 1 in it",
    "loft": "write `blend(extrude(a, h), extrude(b, h), z, r)`: from one to the other along z, within r",
    **dict.fromkeys(("sweep", "bezier", "nurbs"), f"curves are lists of points: {_LINES}"),
    "taper": "write `f @ [x / s, y / s, z]` with s a function of z, or `cone(r1, r2, h)`",
    **dict.fromkeys(("text", "font"), "there are no letters: make them of `polygon(points)` and `extrude(profile, h)`"),
    **dict.fromkeys(("voronoi", "noise", "perlin_noise"), _BUILT_IN),
    **dict.fromkeys(("honeycomb", "hex_grid"), "cut copies of `prism(6, r, h)` out of it: `a \\ union([for ...])`"),
    **dict.fromkeys(("strut", "beam", "bar", "rod"), ("capsule", "`capsule(a, b, r)`, or `frame(\"bars.json\")`")),
    **dict.fromkeys(("infill", "lattice"), "write `gyroid(w) |> shell(0.5) & body`, or `shell_to_porosity`"),
    **dict.fromkeys(("hollow", "hollow_out"), 'write `shell(f, 1mm, side="inside")`: a wall below the surface'),
    **dict.fromkeys(("tube", "hollow_cylinder", "annulus"), "write `cylinder(R, h) \\ cylinder(r, h)`"),
    **dict.fromkeys(("cut", "carve"), "write `a \\ b` for a without b"),
    "trim": "write `a & b` for what is in both, `a \\ b` for a without b",
    **dict.fromkeys(("hexagon", "hex"), "write `regular_polygon(6, r)`, or `prism(6, r, h)` for a solid"),
    **dict.fromkeys(("pentagon", "octagon"), "write `regular_polygon(n, r)`, or `prism(n, r, h)` for a solid"),
    "pyramid": "write `octahedron(r) & plane([0, 0, -1])`, or intersect planes: `plane([0, 1, 1], 5) & ...`",
    "attractor": "write `ramp(length(p - [10, 0, 0]), 0, 20)`: from 0 at that point to 1 at 20 mm",
}  # fmt: skip

#: A parameter that a function has not: those that mean the same, of which the first that it has is meant.
PARAMETERS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("radius", "rad"), ("r", "round")),
    **dict.fromkeys(("height", "length", "depth", "l"), ("h",)),
    **dict.fromkeys(("size", "dimensions", "dims", "side", "factor"), ("s", "w")),
    **dict.fromkeys(("period", "wavelength", "cell", "unit_cell", "cell_size", "scale"), ("w", "s")),
    **dict.fromkeys(("thickness", "wall", "width"), ("t", "w")),
    **dict.fromkeys(("distance", "amount", "delta"), ("d",)),
    **dict.fromkeys(("count", "copies", "times", "number"), ("n", "counts")),
    **dict.fromkeys(("rounding", "fillet", "k"), ("r", "round")),
    **dict.fromkeys(("vector", "offset", "by"), ("v",)),
    **dict.fromkeys(("deg", "theta", "turn", "a"), ("angle",)),
    **dict.fromkeys(("r_major", "major", "R1"), ("R",)),
    **dict.fromkeys(("r_minor", "minor", "tube"), ("r",)),
    **dict.fromkeys(("start", "p1", "from"), ("a",)),
    **dict.fromkeys(("end", "p2", "to"), ("b",)),
    **dict.fromkeys(("sides",), ("n",)),
}  # fmt: skip
#: A parameter that no function needs, and why.
NEEDLESS = {
    **dict.fromkeys(("center", "centre", "centered"), "every shape is centred on the origin"),
    **dict.fromkeys(("segments", "fn", "facets", "resolution"), "`pore mesh --voxel` says how fine a mesh is"),
    "convexity": "nothing has to be known of it",
}  # fmt: skip

#: A parameter that another function has: that function, and how it is called.
OTHER_FUNCTIONS = {
    **dict.fromkeys((("cylinder", "r1"), ("cylinder", "r2")), ("cone", "`cone(r1, r2, h)` has two radii")),
    ("cube", "size"): ("box", "`cube(s)` has one length, `box([a, b, c])` three"),
}  # fmt: skip
#: A function that is given a vector for its number: the function that takes one.
OF_A_VECTOR = {"cube": ("box", "a cuboid is `box([a, b, c])`; a cube has one length")}
#: A function that is given a number for its three: the function that takes one.
OF_A_NUMBER = {"box": ("cube", "a box has three lengths, `box([a, b, c])`; a cube has one"),
               "ellipsoid": ("sphere", "`ellipsoid([a, b, c])` has three radii; a sphere has one")}  # fmt: skip
#: What to say of an argument that is missing, by function and parameter.
FORMS = {
    ("rotate", "angle"): "write an axis and an angle, `rotate(f, [0, 0, 1], 45deg)`; turns follow one another by `|>`"
}
#: What to say of a number that is not above 0, by function.
BROKEN = {"scale": "a factor is above 0; `mirror(f, [1, 0, 0])` mirrors at a plane"}
#: Endings of files that hold a mesh.
MESH_ENDINGS = (".stl", ".obj", ".ply", ".3mf", ".glb", ".gltf", ".off", ".step", ".stp", ".vtp", ".vtk", ".vtu")


def hint(word: str, called: bool = False) -> str:
    """What Pore has for a word of another program, that is called or not; nothing for a word that is none."""
    found = NAMES.get(word) or (CALLED.get(word, "") if called else "")
    if isinstance(found, str):
        return found
    return f"write {found[1]}"


def ours(word: str, called: bool = False) -> str:
    """The name that may be put in the place of a word of another program, if there is one."""
    found = NAMES.get(word) or (CALLED.get(word, "") if called else "")
    return "" if isinstance(found, str) else found[0]
