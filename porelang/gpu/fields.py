"""Fields on the GPU: shaders made from graphs, run in the child process, with grids cut to what a buffer holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from porelang.backends.glsl import Form, Shader, shader
from porelang.backends.uniform import uniform_values
from porelang.diagnostics import PoreError, fail
from porelang.gpu import Gpu, GpuFailed, GpuMissing, Lane, shared_gpu
from porelang.ir import Node, order
from porelang.ops import kind

Values = NDArray[Any]
GROUP = 64
#: Drivers take minutes over shaders longer than this; NumPy does not mind.
LONGEST = 6000
#: Samples of a row in one run: Mesa ends loops of more than 65 535 rounds.
LONGEST_ROW = 1 << 20


def gpu(lane: Lane = "work") -> Gpu:
    """The GPU of this process, of a lane. Errors: E120 where there is none, with the command that installs one."""
    try:
        return shared_gpu(lane=lane)
    except GpuMissing as missing:
        raise fail("E120", f"no OpenGL here: {missing.reason}", hint=missing.install) from None


class DeviceField:
    """A root of a flat graph on the GPU, with its params set; float32."""

    def __init__(self, root: Node, params: Mapping[str, float], ranges: Mapping[str, tuple[float, float]], device: Gpu):
        self.root, self.params, self._device = root, params, device
        self.ranges = tuple(sorted(ranges.items()))

    @property
    def device(self) -> Gpu:
        """The device, or this process's own where that has been closed since."""
        if self._device.closed:
            self._device = gpu()
        return self._device

    def at(self, points: Values) -> Values:
        """Values at points (n, 3) in mm, as float32 (n,)."""
        made = _shader(self.root, self.ranges, "points")
        flat = np.ascontiguousarray(points, dtype=np.float32)
        most = self.device.info.max_buffer_bytes // (4 * 3)
        out = np.empty(len(flat), np.float32)
        for start in range(0, len(flat), most):
            part = flat[start : start + most]
            groups = -(-len(part) // GROUP)
            across = min(groups, 32768)
            out[start : start + most] = self._compute(
                made, len(part), part.reshape(-1), {"count": len(part)}, (across, -(-groups // across), 1)
            )
        return out != 0 if kind(self.root) == "bool" else out

    def on_grid(self, axes: Sequence[Values]) -> DeviceGrid:
        """The field on the grid of three coordinate axes, in mm."""
        return DeviceGrid(self, [np.asarray(a, dtype=np.float32) for a in axes])

    def _compute(
        self, made: Shader, count: int, data: Values, uniforms: dict[str, Any], groups: tuple[int, int, int]
    ) -> Values:
        if made.uniforms:
            known = uniform_values(made.uniforms, self.params)
            with np.errstate(over="ignore"):
                uniforms["u"] = np.array([known[n] for n in made.uniforms], dtype=np.float32)
        try:
            return self.device.compute(
                made.text, output=count, inputs=[data], uniforms=uniforms, groups=groups, timeout=600
            )
        except GpuFailed as failed:
            raise _failed(failed) from None


class DeviceGrid:
    """A field on a grid, computed on the GPU block by block."""

    def __init__(self, field: DeviceField, axes: Sequence[Values]):
        self.field, self.axes = field, axes
        self.shape = tuple(len(a) for a in axes)

    def block(self, lo: Sequence[int], hi: Sequence[int], out: Values | None = None) -> Values:
        """Values at the nodes lo <= (i, j, k) < hi, in slabs that the driver's buffers hold."""
        shape = tuple(b - a for a, b in zip(lo, hi, strict=True))
        made = _shader(self.field.root, self.field.ranges, "grid")
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


@lru_cache(maxsize=256)
def _shader(root: Node, ranges: tuple[tuple[str, tuple[float, float]], ...], form: Form) -> Shader:
    length = len(order([root]))
    if length > LONGEST:
        raise fail(
            "E121",
            f"the program is too long for a shader: {length:,} operations, where drivers manage {LONGEST:,}",
            hint="use --backend numpy, which has no such limit",
        )
    return shader(root, dict(ranges), form)


def _failed(error: GpuFailed) -> PoreError:
    log = str(error).strip().splitlines()
    return fail(
        "E122",
        f"the graphics driver failed: {log[0] if log else 'it gave no reason'}",
        hint="use --backend numpy; `pore doctor` examines the driver",
    )
