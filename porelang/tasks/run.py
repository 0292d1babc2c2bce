"""How each task is computed, by its name in the table of tasks."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, TypeVar

import numpy as np

from porelang.data import Data, Reduced, SampledField, Segments, Triple
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.ir import Node, node
from porelang.ops.strut_cells import CELLS
from porelang.ops.studies import NUMBERS as OF_STUDY
from porelang.store import Result
from porelang.tasks.bake import bake
from porelang.tasks.frame import read_cell, read_frame
from porelang.tasks.readers import read_grid
from porelang.tasks.shape import corners_of, look_at_shape, read_shape
from porelang.tasks.truss import cell_of, laid_out

Read = TypeVar("Read")


def _field(asked: Formula, i: int) -> Formula:
    """An argument of a task."""
    return asked.with_roots(asked.roots[i])


def _number(asked: Formula, i: int) -> float:
    return float(_field(asked, i).numbers[0])


def _share(asked: Formula) -> float:
    share = _number(asked, 1)
    if not 0 < share < 1:
        raise fail(
            "E090", f"a porosity of {share:g} cannot be asked for", hint="it lies between 0 and 1: write 50% or 0.5"
        )
    return share


# What finds numbers is imported when one is asked for: `pore check` of a program without them starts without it.


def _porosity(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.integrals import porosity

    return porosity(_field(asked, 0), _field(asked, 1))


def _volume(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.integrals import volume

    return volume(_field(asked, 0))


def _area(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.area import area

    return area(_field(asked, 0))


def _min_wall(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.thickness import min_wall

    return min_wall(_field(asked, 0))


def _minimum(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.extremes import minimum

    return minimum(_field(asked, 0), _field(asked, 1))


def _maximum(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.extremes import maximum

    return maximum(_field(asked, 0), _field(asked, 1))


def _mean(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.integrals import mean

    return mean(_field(asked, 0), _field(asked, 1))


def _to_porosity(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.quantiles import offset_for

    return offset_for(_field(asked, 0), _share(asked), _field(asked, 2))


def _shell_to_porosity(asked: Formula) -> Reduced:
    from porelang.tasks.numbers.quantiles import offset_for

    half = offset_for(asked.with_roots(node("abs", asked.root)), _share(asked), _field(asked, 2))
    return Reduced(2 * half.value, 2 * half.error)


def _sample(asked: Formula) -> Result:
    *fields, voxel, within = range(len(asked.roots))
    return bake(asked.with_roots(*(asked.roots[i] for i in fields)), _number(asked, voxel), _field(asked, within))


#: Of a phase with so many arguments how many are periods; three more are a direction, six the first two of a frame.
_SEVERAL = {8: 1, 10: 3, 11: 1, 13: 3, 14: 1, 16: 3}
#: What `cells` of a phase may be, in the order of the numbers that say which in the graph.
FITS: tuple[Literal["each", "whole", "longest"], ...] = ("each", "whole", "longest")


def _phase(asked: Formula) -> Result:
    from porelang.tasks.phase.asked import phase_of
    from porelang.tasks.phase.find import Fit

    roots, several = asked.roots, _SEVERAL[len(asked.roots)]
    free, volume, how, *counts = (_number(asked, several + 1 + i) for i in range(6))
    way = asked.with_roots(*roots[several + 7 :]) if len(roots) > several + 7 else None
    fit = None if how == 0 else Fit(FITS[int(how) - 1], _cells(counts))
    return phase_of(asked.with_roots(*roots[:several]), _field(asked, several), bool(free), bool(volume), way, fit)


def _study(asked: Formula) -> Result:
    from porelang.tasks.study.found import found

    return found(asked)


def _of_study(asked: Formula) -> Reduced:
    from porelang.tasks.study.got import Got

    study = asked.bindings[asked.roots[0]]
    assert isinstance(study, SampledField)
    return Got.of(study).number(list(OF_STUDY)[int(_number(asked, 1))])


def _truss(asked: Formula) -> Result:
    bars = asked.bindings[asked.roots[0]]
    assert isinstance(bars, Segments)
    x, y, z, r, k = (_number(asked, i) for i in range(1, 6))
    return laid_out(bars, (x, y, z), r, k)


def _cells(counts: Sequence[float]) -> Triple:
    """How many cells a phase is to have along the axes. Errors: E149."""
    for n in counts:
        if n < 0 or n != round(n):
            raise fail("E149", f"{n:g} cells cannot be had", hint="give whole numbers; 0 leaves a side as it comes")
    x, y, z = counts
    return x, y, z


def _blur(asked: Formula) -> Result:
    from porelang.tasks.blur import blurred

    *fields, sigma, voxel, within = range(len(asked.roots))
    several = asked.with_roots(*(asked.roots[i] for i in fields))
    return blurred(several, _number(asked, sigma), _number(asked, voxel), _field(asked, within))


#: Each takes a formula of the task's arguments, fully bound. `solve` is not here: it asks tasks itself (`resolve`).
RUN: Mapping[str, Callable[[Formula], Result]] = {
    "porosity": _porosity,
    "volume": _volume,
    "area": _area,
    "min_wall": _min_wall,
    "minimum": _minimum,
    "maximum": _maximum,
    "mean": _mean,
    "to_porosity": _to_porosity,
    "shell_to_porosity": _shell_to_porosity,
    "sample": _sample,
    "blur": _blur,
    "phase": _phase,
    "study": _study,
    "of_study": _of_study,
    "truss": _truss,
}


#: Of tasks that look at fields within a solid, which argument that is.
_WITHIN = {"porosity": 1, "minimum": 1, "maximum": 1, "mean": 1, "to_porosity": 2, "shell_to_porosity": 2, "sample": -1,
           "blur": -1}  # fmt: skip


def within_of(n: Node) -> Node | None:
    """The solid within which a task looks at its fields; None where it looks at them elsewhere."""
    if n.op == "phase":
        return n.args[_SEVERAL[len(n.args)]]
    return n.args[_WITHIN[n.op]] if n.op in _WITHIN else None


#: What calls a file with so many numbers at each node.
_CALLED = {1: "load", 3: "load_vector", 6: "load_tensor"}
_COUNTED = {1: "one", 3: "three", 6: "six"}


def _load(n: Node) -> Data:
    assert isinstance(n.value, tuple)
    shown, path, name, components, *more = n.value
    voxel, masked, lengths = (float(more[0]), bool(more[1]), float(more[2])) if more else (0.0, False, 0.0)
    grid = _as_named(
        str(shown),
        str(path),
        lambda where: read_grid(where, str(name), voxel=voxel, masked=masked, lengths=lengths or None),
    )
    if grid.components - masked != components:
        held = grid.components - masked
        has = "one number" if held == 1 else f"{held} numbers"
        wanted = f"{_COUNTED[int(components)]} {'is' if components == 1 else 'are'} wanted"
        hint = f"`{_CALLED[held]}` takes {_COUNTED[held]}"
        hint += ", as does a param that is a `vector`" if held == 3 else ""
        raise fail("E133", f"`{name}` of `{shown}` has {has} in each place, where {wanted}", hint=hint)
    return grid


def _frame(n: Node) -> Data:
    assert isinstance(n.value, tuple)
    shown, path = n.value
    return _as_named(str(shown), str(path), read_frame)


def _cell(n: Node) -> Data:
    assert isinstance(n.value, tuple)
    first, *more = n.value
    if not first:
        return cell_of(np.array(more, np.float64).reshape(-1, 2, 3))
    return _as_named(str(first), str(more[0]), read_cell) if more else cell_of(np.array(CELLS[str(first)].bars))


def _mesh(n: Node) -> Data:
    assert isinstance(n.value, tuple)
    shown, path, *numbers, part = n.value
    error, margin, unit = (float(number) or None for number in numbers)
    found = _as_named(str(shown), str(path), lambda where: read_shape(where, error, margin, unit))
    return found if part == "distance" else corners_of(found)


def _look_at_mesh(n: Node) -> None:
    assert isinstance(n.value, tuple)
    _as_named(str(n.value[0]), str(n.value[1]), look_at_shape)


def _as_named(shown: str, path: str, read: Callable[[str], Read]) -> Read:
    """What is read from a path; what goes wrong is told of the path as the program names it."""
    folder, as_shown = os.path.join(os.path.dirname(path), ""), os.path.dirname(shown)
    as_shown = os.path.join(as_shown, "") if as_shown else ""

    def named(text: str) -> str:  # paths stand between backquotes, as does much else
        return text.replace(f"`{path}`", f"`{shown}`").replace(f"`{folder}", f"`{as_shown}")

    try:
        return read(path)
    except PoreError as error:
        told = [replace(d, message=named(d.message), hint=named(d.hint)) for d in error.diagnostics]
        raise PoreError(told) from None


#: What comes from files: each read is remembered by its reader, and known by the digest of what was in it.
READERS: Mapping[str, Callable[[Node], Data]] = {"load": _load, "frame": _frame, "cell": _cell, "mesh": _mesh}
#: Of files that take long to read: what is plainly wrong with one is said without.
LOOKERS: Mapping[str, Callable[[Node], None]] = {"mesh": _look_at_mesh}
