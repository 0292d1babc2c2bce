"""Shaders run on a graphics card, or on Mesa's software one, in a child process that may crash without harm.

`open_gpu` starts the child, `Gpu.compute` and `Gpu.render` run a shader in it. OpenGL drivers crash, hang and print;
nothing of that reaches the process of the user, who sees `GpuMissing` (install something) or `GpuFailed` (with the
driver's log) and may go on: the next call starts a fresh child.

`shared_gpu` has two lanes, each a child of its own: long work, and what a person waits for. Data that many calls read
are named by a digest and stay on the device (`data` of `compute` and `render`).
"""

from porelang.gpu.device import Gpu, Lane, open_gpu, shared_gpu
from porelang.gpu.errors import GpuFailed, GpuMissing
from porelang.gpu.wire import Driver, GpuInfo

__all__ = ["Driver", "Gpu", "GpuFailed", "GpuInfo", "GpuMissing", "Lane", "open_gpu", "shared_gpu"]
