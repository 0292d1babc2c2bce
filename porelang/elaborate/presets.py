"""Presets: named sets of params, `preset "fine": w = 6mm, t = 0.4mm`."""

from __future__ import annotations

from collections.abc import Mapping

from porelang.diagnostics import Edit, Label, suggest
from porelang.elaborate.context import Context
from porelang.elaborate.params import label_of
from porelang.elaborate.results import ParamInfo, Preset
from porelang.elaborate.values import Poison, Scalar, Scope
from porelang.source import Span
from porelang.syntax import tree


def declare_preset(ctx: Context, s: tree.Preset, scope: Scope) -> None:
    """Note a preset. That its values lie in the ranges of their params is looked at when these are all known."""
    before = ctx.found.presets.get(s.name)
    if before is not None:
        ctx.error(
            "E031",
            f'the preset "{s.name}" is written twice',
            s.name_span,
            label="again here",
            others=(Label(before.span, "first here"),),
            hint="give one of them another name",
        )
        return
    if not s.name.strip():
        ctx.error("E087", "a preset needs a name", s.name_span, hint='write `preset "fine": w = 6mm`')
        return
    settings: dict[str, float | str] = {}
    places: dict[str, Span] = {}
    for setting in s.settings:
        if setting.name in places:
            ctx.error(
                "E031",
                f"`{setting.name}` is set twice in this preset",
                setting.name_span,
                label="again here",
                others=(Label(places[setting.name], "first here"),),
                hint="leave one of them out",
            )
            continue
        places[setting.name] = setting.span
        info = ctx.found.params.get(setting.name)
        if info is None:
            _no_param(ctx, setting, scope)
            continue
        value = _value(ctx, setting, info, scope)
        if value is not None:
            settings[setting.name] = value
    ctx.found.presets[s.name] = Preset(s.name, settings, places, s.name_span)


def refuse_dependent(ctx: Context, free: Mapping[str, Preset]) -> None:
    """Refuse values that are known only because params are fixed that something is counted by: `free` are the presets
    as they were read before."""
    for preset in ctx.found.presets.values():
        for name in preset.settings:
            if preset.name not in free or name not in free[preset.name].settings:
                ctx.error(
                    "E063",
                    f"`{name}` of a preset must be known when the program is compiled",
                    preset.places[name],
                    label="it depends on a param",
                    hint="a preset is numbers: write the number itself",
                )


def _no_param(ctx: Context, setting: tree.Setting, scope: Scope) -> None:
    bound = scope.find(setting.name)
    if isinstance(bound, Poison):  # a param that is wrong itself has been told
        return
    near = suggest(setting.name, ctx.declared)
    hint = f"did you mean `{near}`?" if near else f"the params are {', '.join(ctx.declared)}"
    if not ctx.declared:
        hint = f"`param {setting.name} = ... in lo..hi` declares one"
    if bound is not None:
        hint = f"what is set from outside is a param: `param {setting.name} = ... in lo..hi`"
    ctx.error(
        "E087",
        f"a preset sets params, and there is no param `{setting.name}`",
        setting.name_span,
        label="no param",
        hint=hint,
        edit=Edit(setting.name_span, near) if near and bound is None else None,
    )


def _value(ctx: Context, s: tree.Setting, info: ParamInfo, scope: Scope) -> float | str | None:
    """A number in base units, or the label of a choice; None where it is neither, which has been said."""
    if info.choices and not info.numbers:
        wanted = label_of(ctx.evaluate(s.value, scope), s.value)
        if wanted in info.choices:
            return wanted
        ctx.error(
            "E084",
            f"`{s.name}` cannot be `{wanted}`",
            s.value.span,
            label="none of its choices",
            others=(Label(info.span, "declared here"),),
            hint=f"the choices are {', '.join(info.choices)}",
        )
        return None
    value = ctx.evaluate(s.value, scope)
    number = ctx.need_constant(value, s.value.span, f"`{s.name}` of a preset")
    if number is None or not isinstance(value, Scalar):
        return None
    if None not in (value.dimension, info.dimension) and value.dimension != info.dimension:
        ctx.error(
            "E062",
            f"`{s.name}` is {info.dimension} and set to {value.dimension}",
            s.value.span,
            label=f"this is {value.dimension}",
            others=(Label(info.span, f"declared as {info.dimension}"),),
        )
        return None
    return number
