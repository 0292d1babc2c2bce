"""Settings: values for params, from a command line, a Python call or a slider, checked against what they declare."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping

import numpy as np

from porelang.diagnostics import Diagnostic, PoreError, fail, suggest, warn
from porelang.elaborate.results import Elaborated, ParamInfo
from porelang.units import LENGTH, UNITS

Setting = float | int | bool | str
_WRITTEN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z%]*)\s*")


def settle(params: Mapping[str, ParamInfo], given: Mapping[str, Setting]) -> dict[str, float]:
    """The number of every param: its default, or the setting given.

    A setting is a number in base units (mm, rad, N, MPa), a text with a unit (`"2.5cm"`), or the name of a choice.
    Errors: E083 no such param, E084 not a value for it, E085 outside its range.
    """
    values = {name: info.default for name, info in params.items()}
    for name, setting in given.items():
        if name not in params:
            near = suggest(name, params)
            hint = f"did you mean `{near}`?" if near else f"the params are {', '.join(params)}" if params else ""
            raise fail("E083", f"the program has no param `{name}`", hint=hint or "it has none that is a number")
        values[name] = _number(params[name], setting)
    return values


def given(
    found: Elaborated,
    settings: Mapping[str, Setting] | None,
    preset: str | None,
    more: Mapping[str, Setting],
    options: Collection[str],
) -> dict[str, Setting]:
    """What is set, by name, whichever way it was said: by a preset, a mapping, or `more` keywords. A value between two
    steps of its param is a warning (W219).

    Errors: E083, E084, E088. A keyword that is no param may be a slip of one of the `options` of what is asked.
    """
    if not isinstance(settings, Mapping | None):
        hint = 'they are names and values: settings={"w": 25}, or w=25'
        raise fail("E084", f"{settings!r:.60} are no settings", hint=hint)
    if twice := sorted(set(settings or {}) & set(more)):
        raise fail("E084", f"`{twice[0]}` is set twice", hint="in the mapping or by its name, not both")
    for name in {**(settings or {}), **more}:
        if name in found.data:
            raise fail("E083", f"`{name}` takes data, not a number", found.data[name].span, label="declared here",
                       hint=f"bind it: `program.bind({name}=...)`, or `--bind {name}=FILE:ARRAY`")  # fmt: skip
        if name in found.params or suggest(name, found.params):
            continue
        if near := suggest(name, found.data):
            hint = f"did you mean `{near}`, which takes data? `--bind {near}=FILE:ARRAY`"
            raise fail("E083", f"the program has no param `{name}`", hint=hint)
        if name in more and (near := suggest(name, options)):
            raise fail("E083", f"the program has no param `{name}`", hint=f"did you mean the option `{near}`?")
        if name in more:
            known = ", ".join(f"`{n}`" for n in found.params) or "none that is a number"
            raise fail("E083", f"`{name}` is neither an option of what is asked nor a param of the program",
                       hint=f"its params: {known}; options are listed by help(), as help(program.mesh)")  # fmt: skip
    out = {**_preset(found, preset), **(settings or {}), **more}
    values = settle(found.params, out)
    warn(off_step(found.params, {name: values[name] for name in out}))
    return out


def _preset(found: Elaborated, name: str | None) -> Mapping[str, Setting]:
    if name is None:
        return {}
    known = found.presets
    if not isinstance(name, str):
        raise fail("E088", f"{name!r:.60} is no name of a preset", hint='it is a text: preset="fine"')
    if name not in known:
        near = suggest(name, known)
        hint = f"its presets are {', '.join(known)}" if known else 'it has none; `preset "fine": w = 6mm` is one'
        hint = f"did you mean `{near}`?" if near else hint
        raise fail("E088", f"the program has no preset `{name}`", hint=hint)
    return known[name].settings


def _number(info: ParamInfo, setting: Setting) -> float:
    if isinstance(setting, np.ndarray) and not setting.shape:  # a number of NumPy's, as its functions give them
        setting = setting.item()
    if info.choices and not info.numbers:
        return _choice(info, setting)
    if isinstance(setting, bool | np.bool_) or not isinstance(setting, str | int | float | np.number):
        raise fail(
            "E084", f"`{info.name}` cannot be {setting!r}", info.span, label="declared here", hint="give a number"
        )
    try:
        value = _written(info, setting) if isinstance(setting, str) else float(setting)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise fail("E084", f"`{info.name}` cannot be {setting!s:.20}", hint="give a finite number")
    if info.numbers:
        nearest = min(info.numbers, key=lambda n: abs(n - value))
        if abs(nearest - value) > 1e-9 * max(1.0, abs(nearest)):
            raise _outside(info, f"`{info.name}` cannot be {_with_unit(value, info)}", ", ".join(info.choices))
        return nearest
    if info.structural and value != int(value):
        raise fail(
            "E084",
            f"`{info.name}` cannot be {_with_unit(value, info)}: something is counted by it",
            info.span,
            label="declared here",
            hint="give a whole number",
        )
    slack = 1e-12 * max(abs(info.low), abs(info.high))
    if not info.low - slack <= value <= info.high + slack:
        text = f"`{info.name}` = {_with_unit(value, info)} lies outside its range"
        if info.written == "%" and info.low <= value / 100 <= info.high:
            said = f"{value:g} is {100 * value:g}%"
            raise fail("E085", text, info.span, label=f"declared as {info.range}", hint=f"{said}: write `{value:g}%`")
        raise _outside(info, text, f"{_with_unit(info.low, info)} to {_with_unit(info.high, info)}")
    return min(max(value, info.low), info.high)


def _outside(info: ParamInfo, message: str, allowed: str) -> PoreError:
    return fail(
        "E085", message, info.span, label=f"declared as {allowed}", hint=f"choose from {allowed}, or widen the param"
    )


def _written(info: ParamInfo, text: str) -> float:
    match = _WRITTEN.fullmatch(text)
    if match is None:
        raise fail(
            "E084",
            f"`{info.name}` cannot be `{text}`",
            info.span,
            label="declared here",
            hint="write a number, with or without a unit: 25 or 2.5cm",
        )
    number, unit = float(match[1]), match[2]
    if not unit:
        return number
    if unit not in UNITS:
        near = suggest(unit, UNITS)
        raise fail(
            "E084",
            f"there is no unit `{unit}`",
            hint=f"did you mean `{near}`?" if near else f"units are {', '.join(UNITS)}",
        )
    if info.dimension is not None and UNITS[unit].dimension != info.dimension:
        raise fail(
            "E084",
            f"`{info.name}` is {info.dimension}, and {text.strip()} is {UNITS[unit].dimension}",
            info.span,
            label="declared here",
        )
    if info.raw and UNITS[unit].dimension == LENGTH:
        raise fail(
            "E084",
            f"`{info.name}` is a number of the lattice's own units, and {text.strip()} is a length",
            info.span,
            label="declared without a unit",
            hint="give a bare number; for mm declare it in mm, and put `metric(...)` about the lattice",
        )
    return number * UNITS[unit].scale


def _choice(info: ParamInfo, setting: Setting) -> float:
    if isinstance(setting, bool):
        setting = str(setting).lower()
    if isinstance(setting, int | float) and 0 <= setting < len(info.choices) and setting == int(setting):
        return float(setting)
    text = "".join(str(setting).split())  # a list of Python's is written with spaces
    setting = next((label for label in info.choices if "".join(label.split()) == text), setting)
    if setting not in info.choices:
        near = suggest(str(setting), info.choices)
        raise fail(
            "E084",
            f"`{info.name}` cannot be `{setting}`",
            info.span,
            label="declared here",
            hint=f"did you mean `{near}`?" if near else f"choose from {', '.join(info.choices)}",
        )
    return float(info.choices.index(str(setting)))


def _with_unit(value: float, info: ParamInfo) -> str:
    return info.shown(value) if info.written or info.unit in UNITS else f"{value:g}"  # as it may be set


def off_step(params: Mapping[str, ParamInfo], values: Mapping[str, float], default: bool = False) -> list[Diagnostic]:
    """A warning for each value that lies between two steps of its param, counted from the lower end or from 0."""
    out = []
    for name, value in values.items():
        info = params[name]
        if info.step is None or info.choices or value in (info.low, info.high):
            continue
        counts = [(value - start) / info.step for start in (info.low, 0.0)]
        if any(abs(c - round(c)) < 1e-6 for c in counts) or (not default and value == info.default):
            continue
        near = [info.low + info.step * k for k in (np.floor(counts[0]), np.ceil(counts[0]))]
        what = "the default of `{}` is {}" if default else "`{}` = {}"
        out.append(
            Diagnostic(
                "W219",
                f"{what.format(name, info.shown(value))}, between two of its steps of {info.shown(info.step)}",
                info.span,
                "declared with this step",
                hint=f"take {' or '.join(info.shown(float(v)) for v in near if v <= info.high)}, or change the step",
                severity="warning",
            )
        )
    return out
