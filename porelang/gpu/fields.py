"""Fields on the GPU: shaders made from graphs, run in the child process, with grids cut to what a buffer holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.glsl import Form, Shader, shader
from porelang.data import Data, SampledField, Segments
from porelang.diagnostics import PoreError, fail
from porelang.formula import Formula
from porelang.gpu import Gpu, GpuFailed, GpuMissing, Lane, shared_gpu
from porelang.gpu.errors import GpuEnded
from porelang.ir import Node
from porelang.ops import Kind, kind
from porelang.ops.words import words
from porelang.progress import cancelled
from porelang.tape import operations

Values = NDArray[Any]
GROUP = 64
#: Drivers take minutes over shaders longer than this; NumPy does not mind.
LONGEST = 6000
#: Samples of a row in one run: Mesa ends loops of more than 65 535 rounds.
LONGEST_ROW = 1 << 20


def gpu(lane: Lane = "work") -> Gpu:
    """The GPU of this process, of a lane.

    Errors: E120 where there is none, with the command that installs one; E125 where its process was ended before it
    answered.
    """
    try:
        return shared_gpu(lane=lane)
    except GpuEnded as ended:
        raise fail("E125", f"the graphics driver could not be started: {ended.reason}", hint=ended.install) from None
    except GpuMissing as missing:
        raise fail("E120", f"no OpenGL here: {missing.reason}", hint=missing.install) from None


class DeviceField:
    """A formula on the GPU; float32. `params` are the ranges of params, over which a shader's text is right."""

    def __init__(self, formula: Formula, params: Mapping[str, tuple[float, float]], device: Gpu):
        self.formula, self._device = formula, device
        self.params = tuple(sorted(params.items()))

    def __reduce__(self) -> tuple[Callable[..., DeviceField], tuple[Formula, dict[str, tuple[float, float]]]]:
        """Elsewhere it is computed by the GPU that is there. Errors: E120 where it is unpickled and there is none."""
        return _here, (self.formula, dict(self.params))

    @property
    def device(self) -> Gpu:
        """The device, or this process's own where that has been closed since."""
        if self._device.closed:
            self._device = gpu()
        return self._device

    def at(self, points: Values) -> Values:
        """Values at points (n, 3) in mm, as float32: (n,), or (n, k) for k roots."""
        made = _shader(self.formula.roots, self.params, "points")
        flat = np.ascontiguousarray(points, dtype=np.float32)
        count = len(self.formula.roots)
        most = self.device.info.max_buffer_bytes // (4 * max(3, count))
        out = np.empty((len(flat), count), np.float32)
        for start in range(0, len(flat), most):
            part = flat[start : start + most]
            groups = -(-len(part) // GROUP)
            across = min(groups, 32768)
            found = self._compute(
                made, len(part) * count, part.reshape(-1), {"count": len(part)}, (across, -(-groups // across), 1)
            )
            out[start : start + most] = found.reshape(-1, count)
        values = out[:, 0] if count == 1 else out
        return values != 0 if kind(self.formula.root) == "bool" else values

    def on_grid(self, axes: Sequence[Values]) -> DeviceGrid:
        """The field on the grid of three coordinate axes, in mm."""
        return DeviceGrid(self, [np.asarray(a, dtype=np.float32) for a in axes])

    def _compute(
        self, made: Shader, count: int, places: Values, uniforms: dict[str, Any], groups: tuple[int, int, int]
    ) -> Values:
        if made.uniforms:
            with np.errstate(over="ignore"):
                uniforms["u"] = np.array(self.formula.with_roots(*made.uniforms).numbers, dtype=np.float32)
        try:
            return self.device.compute(
                made.text,
                output=count,
                inputs=[places],
                data=resident(self.formula, made),
                uniforms=uniforms,
                groups=groups,
                timeout=600,
                cancel=cancelled,
            )
        except GpuFailed as failed:
            raise _failed(failed) from None


def _here(formula: Formula, params: Mapping[str, tuple[float, float]]) -> DeviceField:
    return DeviceField(formula, params, gpu())


class DeviceGrid:
    """A field on a grid, computed on the GPU block by block."""

    def __init__(self, field: DeviceField, axes: Sequence[Values]):
        self.field, self.axes = field, axes
        self.shape = tuple(len(a) for a in axes)

    def block(self, lo: Sequence[int], hi: Sequence[int], out: Values | None = None) -> Values:
        """Values at the nodes lo <= (i, j, k) < hi, in slabs that the driver's buffers hold."""
        shape = tuple(b - a for a, b in zip(lo, hi, strict=True))
        made = _shader(self.field.formula.roots[:1], self.field.params, "grid")
        most = self.field.device.info.max_buffer_bytes // 4
        nz = min(shape[2], most, LONGEST_ROW)
        ny = min(shape[1], max(1, most // nz), 65535)
        nx = min(shape[0], max(1, most // (nz * ny)), 65535)
        for start in product(range(0, shape[0], nx), range(0, shape[1], ny), range(0, shape[2], nz)):
            size = tuple(min(n, s - o) for n, s, o in zip((nx, ny, nz), shape, start, strict=True))
            cut = [a[b + o : b + o + n] for a, b, o, n in zip(self.axes, lo, start, size, strict=True)]
            groups = (size[1], size[0], 1)
            values = self.field._compute(made, int(np.prod(size)), np.concatenate(cut), {"shape": size}, groups)
            if size == shape and out is None:
                return values.reshape(size)
            if out is None:
                out = np.empty(shape, np.float32)
            out[tuple(slice(o, o + n) for o, n in zip(start, size, strict=True))] = values.reshape(size)
        return np.empty(shape, np.float32) if out is None else out

    def all(self) -> Values:
        """Values at every node."""
        return self.block((0, 0, 0), self.shape)


def resident(formula: Formula, made: Shader) -> list[tuple[str, Callable[[], NDArray[np.uint32]]]]:
    """The data that a shader reads, by digest, and how to get their words where the device does not have them yet."""
    found: list[tuple[str, Callable[[], NDArray[np.uint32]]]] = []
    for n in made.data:
        data = formula.bindings[n]
        if data is None:
            data = _UNREAD[kind(n)]
        assert isinstance(data, SampledField | Segments)
        found.append((data.digest, partial(words, data)))
    return found


#: What a shader is given for data that only a branch reads which is not taken: its text has the branch all the same.
_UNREAD: Mapping[Kind, Data] = {
    "grid": SampledField.from_array(np.zeros((2, 2, 2, 9)), (0, 0, 0), 1.0),
    "segments": Segments(np.zeros((1, 3)), np.ones((1, 3)), np.ones(1)),
}


@lru_cache(maxsize=256)
def _shader(roots: tuple[Node, ...], params: tuple[tuple[str, tuple[float, float]], ...], form: Form) -> Shader:
    length = operations(roots)
    if length > LONGEST:
        raise fail(
            "E121",
            f"the program is too long for a shader: {length:,} operations, where drivers manage {LONGEST:,}",
            hint="use --backend numpy, which has no such limit",
        )
    return shader(roots, dict(params), form)


def _failed(error: GpuFailed) -> PoreError:
    log = str(error).strip().splitlines()
    return fail(
        "E122",
        f"the graphics driver failed: {log[0] if log else 'it gave no reason'}",
        hint="use --backend numpy; `pore doctor` examines the driver",
    )
