"""What can be asked of a program, or of a design: the options, once, and what each stands for.

The methods bind settings and hand on; the work itself is in free functions that take a design (see `asked`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any, Literal

from porelang.analysis.box import Box
from porelang.backends.numpy import Dtype
from porelang.data import Reduced
from porelang.diagnostics import Diagnostic, fail, warn
from porelang.field import Backend, Bounds, Field, make_field
from porelang.picture import Picture
from porelang.settings import Setting

Settings = Mapping[str, Setting]
#: In mm, or a text with a unit: `0.5`, `"0.5mm"`.
Length = float | str


class Doors(ABC):
    """What can be asked: of a program with settings bound, of a design with these set besides."""

    @abstractmethod
    def design(self, settings: Settings | None = None, *, preset: str | None = None, **more: Setting) -> Any:
        """The design that is asked, with settings bound."""

    def field(
        self,
        name: str | None = None,
        /,
        backend: Backend = "numpy",
        dtype: Dtype | None = None,
        threads: int | None = None,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Field:
        """An output, or a `let` that is a number, as a function of points (n, 3) in mm.

        Its values are (n,), or (n, 3) for a vector. Settings are params by name: numbers in base units or texts with a
        unit. `dtype` is f64 unless told otherwise, and f32 with `backend="glsl"`. Whether a `check` holds is not asked.

        >>> import porelang
        >>> program = porelang.compile("sphere(10)")
        >>> program.field("part")([[0, 0, 0], [10, 0, 0]])
        array([-10.,   0.])
        """
        asked = self.design(settings, preset=preset, **more)
        roots = asked.formula(*asked.program.field_roots(name))
        made = make_field(
            roots, asked.program.ranges, backend, dtype or ("f32" if backend == "glsl" else "f64"), threads
        )
        made.of = (asked, asked.program.output() if name is None else name)
        return made

    def bounds(
        self, name: str | None = None, /, settings: Settings | None = None, preset: str | None = None, **more: Setting
    ) -> Box:
        """The box that holds an output's solid, in mm. Errors: E102 where it has no end, E103 where it is empty."""
        box: Box = self.design(settings, preset=preset, **more).extent(name).outer
        return box

    def number(
        self, name: str, /, settings: Settings | None = None, preset: str | None = None, **more: Setting
    ) -> Reduced:
        """An output or a `let` that is one number, in base units, with its error: the true value lies within
        `value +- error`. Errors: E100 where nothing is called so, or it varies in space.

        >>> import porelang
        >>> program = porelang.compile("let d = 4 * volume(sphere(3)) / area(sphere(3))\\nsphere(3)")
        >>> found = program.number("d")
        >>> abs(found.value - 4) <= found.error < 0.01
        True
        """
        asked = self.design(settings, preset=preset, **more)
        (root, *others) = asked.program.field_roots(name)
        if others or root.axes:
            what = "a vector" if others else "a field: it varies in space"
            raise fail("E100", f"`{name}` is {what}", hint=f'ask for its values: `field("{name}")`')
        found: Reduced = asked.valued(root)
        return found

    def notes(
        self, name: str | None = None, /, settings: Settings | None = None, preset: str | None = None, **more: Setting
    ) -> list[Diagnostic]:
        """What was found on the way to an output, or a `let` that is a number, of what tells it: one line each, with
        the place that asks for it. What is doubtful about it is a `PoreWarning`."""
        asked = self.design(settings, preset=preset, **more)
        found: list[Diagnostic] = asked.told(*asked.program.field_roots(name))
        warn(found)
        return [d for d in found if d.severity == "note"]

    def mesh(
        self,
        name: str | None = None,
        /,
        voxel: Length | None = None,
        resolution: int | None = None,
        bounds: Bounds | str | None = None,
        backend: Backend = "numpy",
        dtype: Dtype = "f32",
        smooth: bool = False,
        sharp: bool = False,
        simplify: Length | None = None,
        check: bool = True,
        force: bool = False,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """The surface of an output as a `trimesh.Trimesh` in mm, watertight, normals outward.

        `voxel` is the grid spacing, in mm or as a text with a unit (`"0.5mm"`); or `resolution` counts samples along
        the longest side; if neither is given, or `voxel` is `"auto"`, it is found from the walls. `smooth` moves
        vertices onto the field, `sharp` makes rims edges of the mesh, `simplify` (a length) takes out triangles that
        matter less than that. What is doubtful is told as a `PoreWarning` (W202, W204-W207). Errors:
        those of bounds; E068 where a `check` of the program fails, unless `check` is False; E110, E111, E114 about the
        samples; E118 where more than a fifth of the part is lost, unless `force`.
        """
        from porelang.asked import mesh

        return mesh(
            self.design(settings, preset=preset, **more),
            name,
            voxel,
            resolution,
            bounds,
            backend,
            dtype,
            smooth,
            sharp,
            simplify,
            check,
            force,
        )

    def measure(
        self,
        name: str | None = None,
        /,
        within: str | None = None,
        voxel: Length | None = None,
        resolution: int | None = None,
        bounds: Bounds | str | None = None,
        backend: Backend = "numpy",
        dtype: Dtype = "f32",
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> dict[str, Any]:
        """Volume, porosity, area, components and topology of an output, each with its error under `"error"`.

        Pieces are counted among samples at the `voxel` (or `resolution`), else at one that is found from the walls.
        `within` names the envelope: an output or a let. The keys are those of `pore measure --json`; mm, mm^2, mm^3.
        A `check` of the program that fails is listed under `"failed_checks"`, and told as a `PoreWarning`.
        """
        from porelang.asked import measure

        return measure(
            self.design(settings, preset=preset, **more), name, within, voxel, resolution, bounds, backend, dtype
        )

    def tet(
        self,
        name: str | None = None,
        /,
        size: Length | None = None,
        surface_size: Length | None = None,
        mesher: Literal["direct", "ftetwild"] = "direct",
        phases: str | Sequence[str] = "solid",
        bounds: Bounds | str | None = None,
        keep_islands: bool = False,
        time_limit: float | str | None = None,
        check: bool = True,
        force: bool = False,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """An output as tetrahedra, for analysis: an object with `vertices` (n, 3) in mm, `tets` (m, 4) of positive
        volume, `phase` (m,) with its names `phases`, a `report`, and `write(path)`, `surfaces()`, `to_meshio()`.

        `size` is how long edges are, in mm or as a text with a unit; or the name of an output or a `let` that says it
        at every place; if it is not given, or `"auto"`, it is found from the walls. Near the surface it is
        `surface_size`. The `mesher` is the direct one, or fTetWild (from pytetwild), for which `time_limit` is (s, or
        `"5min"`). `phases="solid,void"` fills the void in the part's box too, with the triangles between them shared.
        Pieces that do not hang together with the largest are left out unless `keep_islands`. What is doubtful is told
        as a `PoreWarning` (W202, W250-W253). Errors: those of bounds; E068 where a `check` of the program fails, unless
        `check` is False; E118 where more than a fifth of the part is lost, unless `force`; E160-E165.

        >>> import porelang
        >>> ball = porelang.compile("sphere(10)").tet(size=4)
        >>> abs(ball.report["volume"] / 4188.79 - 1) < 0.1
        True
        >>> sorted(ball.surfaces())
        ['solid_outside']
        """
        from porelang.asked import tet

        return tet(
            self.design(settings, preset=preset, **more),
            name,
            size,
            surface_size,
            mesher,
            phases,
            bounds,
            keep_islands,
            time_limit,
            check,
            force,
        )

    def study(
        self,
        name: str | None = None,
        /,
        refine: bool = False,
        within: str | None = None,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """A study of the program in elements (`porelang.strength.Strength`): the one that a `let` names, the only one,
        or one that is described as a program calls it, `"compress(part, 10kN, axis=z, E=2GPa, nu=0.3)"`. With its mesh,
        what was found on it, its `numbers` with their errors, and `write("result.vtu")`.

        `refine` adds a step of refinement where stresses err most; `within` names the envelope of an effective modulus.
        What is doubtful is told as a `PoreWarning`. Errors: E100 where there is no such study; those of the study.
        """
        from porelang.asked import study

        return study(self.design(settings, preset=preset, **more), name, refine, within)

    def iterate(
        self,
        name: str | None = None,
        /,
        until: float | str = 0.005,
        most: int = 15,
        rule: Any = "energy",
        limits: tuple[float, float] | str = (0.2, 0.8),
        porosity: float | str | None = None,
        adapt: str | None = None,
        study: str | None = None,
        within: str | None = None,
        cell: Length | None = None,
        damping: float | str = 1.0,
        folder: str | Path | None = None,
        resume: bool = False,
        force: bool = False,
        early: str | None = None,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """The loop from stress back to geometry for an output (`porelang.optimize.run.Optimized`): its `steps`, the
        `best` of them, a `table`, a `plot()`, the `samples` of the param that adapts, the `design` with these bound.

        The study of the output is solved, what is borne becomes thickness, the porosity is restored, and again: until
        the compliance changes by less than `until`, or `most` steps were made. `rule` is "energy", "von_mises" or
        "optimum", or one of `porelang.optimize.rules`; `limits` are of the density. The optimum, and what is `early`
        "homogenised", is first found on the homogenised lattice. `folder` keeps a record and the best so far; `resume`
        goes on with it, `force` begins anew there. Shares may be texts: `until="0.5%"`, `limits="0.2..0.8"`. What is
        doubtful is told as a `PoreWarning`. Errors: E108, E190-E195, those of the study and of the cell.
        """
        from porelang.asked import iterate

        return iterate(self.design(settings, preset=preset, **more), name, until, most, rule, limits, porosity, adapt,
                       study, within, cell, damping, folder, resume, force, early)  # fmt: skip

    def slices(
        self,
        name: str | None = None,
        /,
        *,
        folder: str | Path,
        step: Length,
        format: Literal["png", "svg"] = "png",
        voxel: Length | None = None,
        bounds: Bounds | str | None = None,
        backend: Backend = "numpy",
        dtype: Dtype = "f32",
        check: bool = True,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> dict[str, Any]:
        """Write the layers of an output into a folder, whole or not at all, and return their manifest.

        A layer every `step`, as pictures whose pixels are `voxel` wide (the step unless given), or as SVG contours in
        mm. Lengths are in mm or texts with a unit. Errors: those of a mesh; E113 about the folder.
        """
        from porelang.asked import slices

        return slices(
            self.design(settings, preset=preset, **more),
            name,
            folder,
            step,
            format,
            voxel,
            bounds,
            backend,
            dtype,
            check,
        )

    def render(
        self,
        name: str | Sequence[str] | None = None,
        /,
        *,
        bodies: bool = False,
        view: str | tuple[float, float] = "iso",
        projection: Literal["perspective", "orthographic"] = "perspective",
        size: str | tuple[int, int] = (800, 600),
        zoom: float = 1.0,
        cut: str | Sequence[str] = (),
        slice: str | Sequence[str] = (),
        field: str | None = None,
        range: str | tuple[float, float] | None = None,
        legend: bool | str = False,
        deform: bool | str | float = False,
        ghost: bool = False,
        solid: Literal["none", "opaque", "glass"] | None = None,
        background: Literal["white", "transparent"] = "white",
        samples: int = 3,
        axes: bool = False,
        scale_bar: bool = False,
        frame: Literal["surface", "bounds"] = "surface",
        bounds: Bounds | str | None = None,
        check: bool = True,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Picture:
        """A picture of an output, or of several in colours of their own; a notebook shows it.

        The options are those of `pore render` (docs/render.md), as there or as values: `view="front"` or degrees
        `(azimuth, elevation)`, `size="800x600"` or pixels, `cut="y<0"` or several, `slice="z=1cm"`, `field="heat"` on
        the slices or else on the surface, `range=(0, 1)`, `legend=True` or a text, `deform="s"` or `"120 s"`, a number
        or True where there is one study. Errors: those of bounds; E068 where a `check` fails, unless `check` is False;
        E107, E108 for wishes that cannot be; E120-E122 about OpenGL; E179 about a deformation.
        """
        from porelang.asked import render

        return render(
            self.design(settings, preset=preset, **more),
            name,
            bodies=bodies,
            view=view,
            projection=projection,
            size=size,
            zoom=zoom,
            cut=cut,
            slice=slice,
            field=field,
            range=range,
            legend=legend,
            deform=deform,
            ghost=ghost,
            solid=solid,
            background=background,
            samples=samples,
            axes=axes,
            scale_bar=scale_bar,
            frame=frame,
            bounds=bounds,
            check=check,
        )

    def view(
        self,
        name: str | Sequence[str] | None = None,
        /,
        *,
        paint: str = "",
        plane: bool = False,
        cut: str = "",
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """The part in a notebook, to be turned, cut and set (`porelang.notebook.widget.Viewer`): what `pore view` shows
        on a page, of an output or of several.

        `paint` is a field that gives the colours, `cut` a section as `"y<0"`, `plane` shows the field on it. These,
        `settings` and `outputs` are traits of the viewer: what is moved there changes them, and what is assigned here
        moves what is there. Errors: E100 for the output, those of settings, E126 where anywidget is missing.
        """
        from porelang.notebook.display import view

        return view(self.design(settings, preset=preset, **more), name, paint=paint, plane=plane, cut=cut)

    def _repr_mimebundle_(self, **_: Any) -> Any:
        """What a notebook shows; what goes wrong with that leaves the tables."""
        from porelang.notebook.display import bundle

        return bundle(self)

    def homogenize(
        self,
        name: str | None = None,
        /,
        cell: float | str | Sequence[float | str] | None = None,
        nu: float | str = 0.3,
        resolution: int | str = 64,
        sweep: str | None = None,
        check: bool = True,
        settings: Settings | None = None,
        preset: str | None = None,
        **more: Setting,
    ) -> Any:
        """One period of an output as a material, for a solid of unit Young's modulus and the Poisson's ratio `nu`.

        `cell` are the sides of the period in mm (`(10, 10, 15)`, `"1cm,1cm,15mm"`, or one of a cube), else those of its
        lattices; `resolution` counts voxels along the longest side of the finest grid, in eights. Gives a
        `porelang.homogenize.Homogenized`: stiffness (6, 6), conductivity (3, 3), `numbers` and `errors`, `report()`,
        `picture()`; print it. With `sweep="t=0.2..1.2:6"` gives a `porelang.homogenize.Swept`, its `law` a function of
        the density. What was solved is kept. What is doubtful is told as a `PoreWarning` (W260-W263). Errors: those of
        an output; E068 where a `check` fails, unless `check` is False; E180-E183.

        >>> import porelang
        >>> found = porelang.compile("gyroid(10)").homogenize(resolution=16)
        >>> 0.1 < found.numbers["E.100"] < found.numbers["E.111"] < 0.3
        True
        """
        from porelang.asked import homogenize

        return homogenize(self.design(settings, preset=preset, **more), name, cell, nu, resolution, sweep, check,
                          {*(settings or {}), *more})  # fmt: skip


@cache
def options() -> frozenset[str]:
    """The options of all that can be asked."""
    asked = (
        Doors.field, Doors.bounds, Doors.number, Doors.mesh, Doors.measure, Doors.tet, Doors.study, Doors.iterate,
        Doors.slices, Doors.render, Doors.homogenize, Doors.view,
    )  # fmt: skip
    every = frozenset(option for one in asked for option in signature(one).parameters)
    return every - {"self", "name", "more"}
