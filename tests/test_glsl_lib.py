"""The functions of shaders/lib, swept over hard inputs on the driver and held against float64 NumPy.

A bound is `ulp` units in the last place of the exact result plus `absolute` plus `extra(arguments)`; special values are
compared exactly. Numbers too small for a normal float may count as 0, in arguments and results.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from porelang.gpu import Gpu
from porelang.resources import folder

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
LIB = folder("shaders") / "lib"
SOURCES = {path.stem: path.read_text(encoding="utf-8") for path in sorted(LIB.glob("*.glsl"))}
TINY = float(np.finfo(np.float32).tiny)
LARGEST = float(np.finfo(np.float32).max)
COMMENT = re.compile(r"//.*")


def library(text: str, seen: dict[str, str] | None = None) -> str:
    """The functions of the library that a text calls, each after those that it calls itself."""
    seen = {} if seen is None else seen
    for name in re.findall(r"\b((?:pore_|Pore)\w+)@?\(", COMMENT.sub("", text)):
        if name not in seen and name != "pore_word":
            seen[name] = ""  # its own definition looks like a call
            library(SOURCES[name], seen)
            seen[name] = seen.pop(name) or SOURCES[name]
    return "\n".join(seen.values())


def shader(expression: str, arity: int, head: str = "#version 430\n") -> str:
    inputs = "".join(f"layout(std430, binding = {k + 1}) readonly buffer I{k} {{ float i{k}[]; }};\n" for k in range(2))
    second = "i1[i]" if arity == 2 else "0.0"
    return f"""{head}layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Out {{ float o[]; }};
{inputs}{library(expression)}
void main() {{
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(o.length())) return;
    float a = i0[i];
    float b = {second};
    o[i] = {expression};
}}
"""


def run(gpu: Gpu, expression: str, *args: F32, head: str = "#version 430\n") -> F32:
    padded = (*args, args[0])[:2]
    groups = -(-args[0].size // 64)
    source = shader(expression, len(args), head)
    return gpu.compute(source, output=args[0].size, inputs=padded, groups=(groups, 1, 1))


# ---- hard inputs -----------------------------------------------------------------------------------------------------
RNG = np.random.default_rng(20240229)
SPECIAL = [0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 1e-40, -1e-40, TINY, -TINY, LARGEST, -LARGEST]


def beside(values: Any) -> F32:
    """Numbers and the floats next to them, with both signs."""
    v = np.asarray(values, np.float32)
    with np.errstate(over="ignore"):
        v = np.concatenate([v, np.nextafter(v, np.float32(np.inf)), np.nextafter(v, np.float32(-np.inf))])
    return np.concatenate([v, -v])


def spread(count: int, lo: float = -126, hi: float = 127.9) -> F32:
    """Log-uniform numbers of both signs, of the magnitudes 2^lo .. 2^hi."""
    return np.asarray(np.exp2(RNG.uniform(lo, hi, count)) * RNG.choice([-1, 1], count), np.float32)


def uniform(lo: float, hi: float, count: int) -> F32:
    return RNG.uniform(lo, hi, count).astype(np.float32)


LINE = np.concatenate(
    [
        np.array(SPECIAL, np.float32),
        beside(np.ldexp(1.0, np.arange(-126, 128))),
        beside(np.arange(0, 2000) / 8),  # multiples of an eighth of a turn, halves and whole numbers
        beside(np.arange(0, 2000) * np.pi / 4),
        beside([88.72283, -87.33654, -103.97, 0.70710678, 1.4142135, 2.0**23 + 0.5, 2.0**24, 1e7]),
        spread(60_000),
        *(uniform(-k, k, 30_000) for k in (1, 4, 100, 1e4, 1e7)),
        (1 + RNG.uniform(-1, 1, 20_000) * np.exp2(RNG.uniform(-23, -1, 20_000))).astype(np.float32),
    ]
)


def pairs(*more: tuple[F32, F32]) -> tuple[F32, F32]:
    special = np.array([*SPECIAL, 0.5, -0.5, 2, -2, 3, -3, 2.5, 1e30, -1e30, 1e-30, 8388609, 16777217], np.float32)
    special = np.concatenate([special, beside([1.0])])
    a, b = (m.ravel() for m in np.meshgrid(special, special))
    plane = (uniform(-50, 50, 60_000), uniform(-5, 5, 60_000))
    wide = (spread(60_000), spread(60_000))
    both = [(a, b), plane, wide, *more]
    return np.concatenate([p[0] for p in both]), np.concatenate([p[1] for p in both])


def powers() -> tuple[F32, F32]:
    """Bases of all sizes, and near 1, with exponents up to the limits of the result; small whole exponents."""
    near = (1 + RNG.uniform(-1, 1, 60_000) * np.exp2(RNG.uniform(-23, -1, 60_000))).astype(np.float32)
    base = np.concatenate([np.abs(spread(60_000)), np.where(near == 1, np.float32(1.5), near)])
    exponent = RNG.uniform(-127, 127, base.size) * RNG.uniform(0, 1, base.size) / np.log2(base.astype(float))
    whole = (uniform(-20, 20, 40_000), RNG.integers(-20, 21, 40_000).astype(np.float32))
    return pairs((base, exponent.astype(np.float32)), whole)


NEAR_EQUAL = np.abs(spread(40_000, -60, 60))
PAIRS = pairs((NEAR_EQUAL, NEAR_EQUAL * uniform(0.4, 2.5, 40_000)))


# ---- the table -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Row:
    """A function, its exact value in float64, and how far float32 may be from it."""

    call: str
    exact: Callable[..., Any]
    args: tuple[F32, ...]
    ulp: float = 0.0
    absolute: float = 0.0
    extra: Callable[..., F64] | None = None

    def __str__(self) -> str:
        return self.call.partition("(")[0]


def in_turns(f: Callable[..., Any]) -> Callable[..., Any]:
    return lambda u: f(2 * np.pi * (u - np.rint(u)))


def power_growth(a: F64, b: F64) -> F64:
    """The part of a power's bound that grows with its exponent, relative to the result."""
    return 2.0**-23 / 24 * np.abs(b * np.log2(np.abs(a))) * np.abs(np.power(a, b))


def away_from_0(a: F64) -> F64:
    return 2.0**-47 * np.abs(a)


TABLE = [
    Row("pore_sin_turns(a)", in_turns(np.sin), (LINE,), absolute=1.5e-7),
    Row("pore_cos_turns(a)", in_turns(np.cos), (LINE,), absolute=1.5e-7),
    Row("pore_reduced(a)", in_turns(np.positive), (LINE,), ulp=1.0),
    Row("pore_sin(a)", np.sin, (LINE,), absolute=2e-7, extra=away_from_0),
    Row("pore_cos(a)", np.cos, (LINE,), absolute=1.5e-7, extra=away_from_0),
    Row("pore_exp(a)", np.exp, (LINE,), ulp=1.0),
    Row("pore_log(a)", np.log, (LINE,), ulp=0.9),
    Row("pore_sqrt(a)", np.sqrt, (LINE,), ulp=0.5000001),
    Row("pore_asin(a)", np.arcsin, (LINE,), ulp=2.5),
    Row("pore_acos(a)", np.arccos, (LINE,), ulp=1.5),
    Row("pore_floor(a)", np.floor, (LINE,)),
    Row("pore_round(a)", np.rint, (LINE,)),
    Row("pore_sign(a)", np.sign, (LINE,)),
    Row("pore_keep(a)", np.positive, (LINE,)),
    Row("pore_div(a, b)", np.divide, PAIRS, ulp=0.5000001),
    Row("pore_pow(a, b)", np.power, powers(), ulp=1.3, extra=power_growth),
    Row("pore_atan2(a, b)", np.arctan2, PAIRS, ulp=1.7),
    Row("pore_min(a, b)", np.minimum, PAIRS),
    Row("pore_max(a, b)", np.maximum, PAIRS),
]


def right(row: Row, got: F64, args: tuple[F64, ...]) -> NDArray[np.bool_]:
    """Which results lie within the bound of the exact value; infinities, NaN and signs of infinities exactly."""
    exact = np.asarray(row.exact(*args), float)
    ulp = np.spacing(np.clip(np.abs(exact), TINY, LARGEST).astype(np.float32)).astype(float)
    bound = row.ulp * ulp + row.absolute + (row.extra(*args) if row.extra else 0.0)
    near = np.abs(got - exact) <= np.where(np.isfinite(bound), bound, 0.0)
    near |= (np.abs(exact) < TINY) & (np.abs(got) <= TINY)
    near |= (np.abs(exact) >= LARGEST * (1 - 2.0**-24 * row.ulp)) & (got == np.copysign(np.inf, exact))
    return np.asarray(near | (got == exact) | (np.isnan(got) & np.isnan(exact)))


@pytest.mark.parametrize("row", TABLE, ids=str)
def test_the_bound_holds(gpu: Gpu, row: Row) -> None:
    assert row.args[0].size >= 100_000
    got = run(gpu, row.call, *row.args).astype(float)
    with np.errstate(all="ignore"):
        wide = tuple(a.astype(float) for a in row.args)
        flushed = tuple(np.where(np.abs(a) < TINY, np.copysign(0.0, a), a) for a in wide)
        ok = right(row, got, wide) | right(row, got, flushed)
    wrong = np.flatnonzero(~ok)[:5]
    shown = [
        (*(float(a[i]) for a in row.args), "gives", got[i], "not", row.exact(*(a[i] for a in wide))) for i in wrong
    ]
    assert ok.all(), f"{row.call} is wrong for {(~ok).sum()} arguments, as {shown}"


def test_sqrt_is_rounded_correctly_for_every_mantissa_of_a_sample(gpu: Gpu) -> None:
    x = (np.arange(0, 2**24, 7, dtype=np.uint32) + np.uint32(127 << 23)).view(np.float32)  # 1 .. 4
    x = np.append(x, np.float32(3.9999998))  # the hardest of them: its root is a hair below a midpoint
    np.testing.assert_array_equal(run(gpu, "pore_sqrt(a)", x), np.sqrt(x))


def test_division_and_remainder_equal_those_of_numpy_in_float32(gpu: Gpu) -> None:
    a, b = PAIRS
    with np.errstate(all="ignore"):
        quotient = a / b
        remainder = a - b * np.floor(quotient)
    normal = (np.abs(quotient) >= TINY) & (np.abs(a) >= TINY) & (np.abs(b) >= TINY)
    np.testing.assert_array_equal(run(gpu, "pore_div(a, b)", a, b)[normal], quotient[normal])
    np.testing.assert_array_equal(run(gpu, "pore_mod(a, b)", a, b)[normal], remainder[normal])
    zero = np.float32(0)
    assert np.isnan(run(gpu, "pore_mod(a, b)", np.array([1, zero, np.inf], "f"), np.array([0, 0, 3], "f"))).all()


@pytest.mark.parametrize("call", ["pore_div(a, b)", "pore_atan2(a, b)", "pore_pow(a, b)"])
def test_zeros_keep_the_signs_that_ieee_gives(gpu: Gpu, call: str) -> None:
    special = np.array([0.0, -0.0, 1.0, -1.0, 3.0, -3.0, 2.0, -2.0, np.inf, -np.inf], np.float32)
    a, b = (m.ravel() for m in np.meshgrid(special, special))
    function = {"pore_div": np.divide, "pore_atan2": np.arctan2, "pore_pow": np.power}[call.partition("(")[0]]
    with np.errstate(all="ignore"):
        want = function(a, b)
    got = run(gpu, call, a, b)
    zero = want == 0
    assert zero.sum() > 10
    np.testing.assert_array_equal(np.signbit(got[zero]), np.signbit(want[zero]))


@pytest.mark.parametrize(
    ("call", "value"),
    [
        ("pore_div(1.0, 0.0)", np.inf),
        ("pore_div(-1.0, 0.0)", -np.inf),
        ("pore_div(0.0, 0.0)", np.nan),
        ("pore_sqrt(-1.0)", np.nan),
        ("pore_log(0.0)", -np.inf),
        ("pore_pow(0.0, 0.0)", 1.0),
        ("pore_pow(-2.0, 2.0)", 4.0),
        ("pore_atan2(0.0, 0.0)", 0.0),
        ("pore_max(pore_nan(), 1.0)", np.nan),
        ("pore_min(1.0, pore_nan())", np.nan),
        ("pore_sign(pore_nan())", np.nan),
        ("-pore_inf()", -np.inf),
        ("pore_is_nan(pore_nan()) && !pore_is_nan(pore_inf()) ? 1.0 : 0.0", 1.0),
    ],
)
def test_constants_are_folded_as_they_would_be_computed(gpu: Gpu, call: str, value: float) -> None:
    got = run(gpu, call, np.zeros(3, np.float32))
    np.testing.assert_array_equal(got, np.full(3, value, np.float32))


# ---- the texts -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", SOURCES)
def test_a_file_holds_one_documented_function_of_its_name(name: str) -> None:
    source = SOURCES[name]
    assert source.startswith("// ")
    made = re.findall(r"^\w+ (\w+)@?\(.*\) \{$|^uniform float (\w+);$|^struct (\w+) \{$", source, re.MULTILINE)
    assert ["".join(m) for m in made] == [name]
    assert len(library(f"{name}(")) >= len(source)  # everything it calls is there
    assert not re.findall(r"(?<!\w)@|@(?!\()", source)  # `name@(` alone: the number of a data slot


def test_no_two_files_are_one_where_capitals_do_not_count() -> None:
    assert len({name.lower() for name in SOURCES}) == len(SOURCES)


@pytest.mark.parametrize("name", SOURCES)
def test_no_function_of_undefined_precision_is_called(name: str) -> None:
    loose = {"sin", "cos", "tan", "asin", "acos", "atan", "exp", "exp2", "log", "log2", "pow", "inversesqrt", "mod"}
    loose |= {"min", "max", "clamp", "round", "sign", "mix", "fma", "isnan", "isinf", "length", "dot", "normalize"}
    code = COMMENT.sub("", SOURCES[name])
    assert not set(re.findall(r"\b(\w+)\(", code)) & loose
    assert name == "pore_sqrt" or not re.search(r"\bsqrt\(", code)


@pytest.mark.parametrize("name", SOURCES)
def test_every_rounded_result_is_precise(name: str) -> None:
    """A driver may fuse or reorder sums and products in a declaration that is not `precise`."""
    code = COMMENT.sub("", SOURCES[name])
    for variable, value in re.findall(r"(?<!precise )\bfloat (\w+) = ([^;]*);", code):
        rounds = re.search(r" [-+*/] ", value) and not re.match(r"(uintBitsToFloat|float)\(", value)  # whole numbers
        assert not rounds, f"{variable} = {value}"


def test_the_library_is_valid_for_opengl_es(gpu: Gpu) -> None:
    """WebGL2 speaks ES 3.00, which knows no implicit conversion and no `precise`; 3.10 adds the buffers used here."""
    head = "#version 310 es\nprecision highp float;\nprecision highp int;\n#define precise\n"
    x = uniform(0.1, 0.9, 1000)
    for name in (
        "sin_turns",
        "cos_turns",
        "sin",
        "cos",
        "exp",
        "log",
        "sqrt",
        "asin",
        "acos",
        "floor",
        "round",
        "sign",
    ):
        call = f"pore_{name}(a)"
        np.testing.assert_allclose(run(gpu, call, x, head=head), run(gpu, call, x), rtol=1e-6, atol=1e-6)
    for name in ("div", "pow", "atan2", "min", "max", "mod"):
        call = f"pore_{name}(a, b)"
        np.testing.assert_allclose(run(gpu, call, x, x[::-1], head=head), run(gpu, call, x, x[::-1]), rtol=1e-5)
