"""What a picture should show, and the words for it, on the command line and in a call."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from porelang.diagnostics import fail
from porelang.render.camera import VIEWS, Projection
from porelang.render.cuts import Cut, HalfSpace
from porelang.render.deform import Deform
from porelang.render.planes import Plane
from porelang.render.scale import Colouring, wished

Solid = Literal["none", "opaque", "glass"]
#: What fills a picture: the surface that is seen, or the part's bounds, which other settings may leave as they are.
Frame = Literal["surface", "bounds"]


@dataclass(frozen=True, slots=True)
class Wishes:
    """What a picture should show: `view` is azimuth and elevation in degrees, `samples` squared make a pixel.

    `field` is shown on the planes `slices`, or on the surface where there are none. Its `scale` is found where it is
    None. `legend` is the text above the scale's numbers, "" for the unit of the field where that is known, None for no
    legend; of several outputs it names the colours. `axes` draws a triad, `scale_bar` a round length in mm. `frame` is
    what fills the picture where there are no planes. `deform` draws the deformed part, `ghost` the outline of the
    undeformed one with it.
    """

    size: tuple[int, int] = (800, 600)
    view: tuple[float, float] = VIEWS["iso"]
    projection: Projection = "perspective"
    zoom: float = 1.0
    samples: int = 3
    cuts: tuple[Cut, ...] = ()
    slices: tuple[Plane, ...] = ()
    field: str | None = None
    scale: Colouring | None = None
    legend: str | None = None
    solid: Solid = "opaque"
    transparent: bool = False
    axes: bool = False
    scale_bar: bool = False
    frame: Frame = "surface"
    deform: Deform | None = None
    ghost: bool = False


def wishes_of(
    *,
    view: str | tuple[float, float] = "iso",
    projection: Projection = "perspective",
    size: tuple[int, int] = (800, 600),
    zoom: float = 1.0,
    cut: Iterable[Sequence[tuple[int, bool, float]]] = (),
    slice: Iterable[tuple[int, float]] = (),
    field: str | None = None,
    range: tuple[float, float] | None = None,
    legend: str | None = None,
    solid: Solid | None = None,
    background: Literal["white", "transparent"] = "white",
    samples: int = 3,
    axes: bool = False,
    scale_bar: bool = False,
    frame: Frame = "surface",
    deform: tuple[float | None, str] | None = None,
    ghost: bool = False,
    several: bool = False,
) -> Wishes:
    """Wishes from the values of options, as `porelang.values` reads them; `several` outputs are drawn.

    Errors: E108 where one is about what is not there.
    """
    slices = tuple(Plane(*p) for p in slice)
    if range is not None and not slices and field is None:
        raise fail("E108", "--range is about the colours of a field, and none is shown",
                   hint="add --field NAME for the surface, or a plane: --slice x=0")  # fmt: skip
    if legend is not None and not slices and field is None and not several:
        raise fail("E108", "--legend is about colours, and there are none",
                   hint="add --field NAME, a plane (--slice x=0), or a second --out")  # fmt: skip
    if field is not None and not slices and solid == "glass":
        raise fail("E108", "glass has no colours for --field", hint="leave --solid out, or add a plane: --slice x=0")
    if solid == "none" and not slices:
        raise fail("E108", "--solid none leaves nothing to be seen", hint="add a plane, as in --slice x=0")
    if ghost and deform is None:
        raise fail("E108", "--ghost is about the undeformed part beside the deformed one, which is not drawn",
                   hint="add --deform")  # fmt: skip
    if deform is not None:
        for given, why, hint in (
            (slices, "--slice draws planes, which do not deform", "cut the part open instead: --cut 'y<0'"),
            (solid == "glass", "a deformed part is not drawn as glass", "leave --solid out"),
            (several, "a deformed part is drawn alone", "choose one output with --out NAME"),
        ):
            if given:
                raise fail("E108", f"{why}: --deform goes without", hint=hint)
    return Wishes(
        size=size,
        view=VIEWS[view] if isinstance(view, str) else view,
        projection=projection,
        zoom=zoom,
        samples=samples,
        cuts=tuple(tuple(HalfSpace(*side) for side in c) for c in cut),
        slices=slices,
        field=field,
        scale=None if range is None else wished(*range, on_planes=bool(slices)),
        legend=legend,
        solid=solid or ("glass" if slices and not several else "opaque"),
        transparent=background == "transparent",
        axes=axes,
        scale_bar=scale_bar,
        frame=frame,
        deform=None if deform is None else Deform(deform[1], deform[0]),
        ghost=ghost,
    )
