"""The process that talks to the OpenGL driver: `python -m porelang.gpu.child SOCKET ARENA DRIVER`.

It answers one request at a time until the socket is closed. Its standard input is a lifeline: nothing is ever
written to it, and when the parent ends, in whatever way, the kernel sends SIGIO, which ends this process even in the
middle of a shader.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import signal
import sys
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from porelang.gpu.context import open_context
from porelang.gpu.wire import Arena, Compute, Done, Failed, GpuInfo, Keep, Render, Request, offsets

PROGRAMS = 64  # kept compiled, the least recently used goes first
CORNERS = """#version 330 core
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
"""
NUMBERS: dict[str, np.dtype[Any]] = {"f": np.dtype("f4"), "d": np.dtype("f8"), "i": np.dtype("i4"), "I": np.dtype("u4")}


class Refused(Exception):  # noqa: N818
    """A request that cannot be fulfilled, with the driver's log."""

    def __init__(self, reason: str, log: str = "") -> None:
        self.reason, self.log = reason, log


@dataclass(frozen=True, slots=True)
class Program:
    """A compiled shader; `corners` draws the triangle that covers a picture."""

    members: Any
    corners: moderngl.VertexArray | None = None

    def release(self) -> None:
        if self.corners is not None:
            self.corners.release()
        self.members.release()


class DriverState:
    """The context, its compiled programs and its buffers: those written at every call, and the data kept by digest."""

    def __init__(self, driver: str, arena: Arena) -> None:
        self.context, self.arena, self.driver = open_context(driver), arena, driver
        self.programs: OrderedDict[tuple[type, str], Program] = OrderedDict()
        self.buffers: dict[int, moderngl.Buffer] = {}
        self.data: dict[str, moderngl.Buffer] = {}
        self.picture: moderngl.Framebuffer | None = None
        self.compiled = 0

    @property
    def info(self) -> GpuInfo:
        info, code = self.context.info, self.context.version_code
        return GpuInfo(
            driver=self.driver,
            renderer=info["GL_RENDERER"],
            vendor=info["GL_VENDOR"],
            version=info["GL_VERSION"],
            glsl=f"{code // 100}.{code % 100}",
            max_buffer_bytes=info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"],
            max_buffers=min(info[f"GL_MAX_{stage}_SHADER_STORAGE_BLOCKS"] for stage in ("COMPUTE", "FRAGMENT")),
            max_groups=tuple(info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"]),
        )

    def answer(self, request: Request) -> Done | Failed:
        """Run one request; whatever goes wrong becomes a `Failed`."""
        before = self.compiled
        try:
            match request:
                case Compute():
                    self.compute(request)
                case Render():
                    self.render(request)
                case Keep():
                    self.keep(request)
            self.check()
        except Refused as refused:
            return Failed(refused.reason, refused.log, self.compiled - before)
        except (moderngl.Error, ValueError, TypeError, MemoryError) as error:
            return Failed("OpenGL refused the request", str(error), self.compiled - before)
        return Done(self.compiled - before)

    def check(self) -> None:
        if (error := self.context.error) != "GL_NO_ERROR":
            raise Refused(f"OpenGL reports {error}")

    def keep(self, request: Keep) -> None:
        for digest in (*request.dropped, request.digest):  # the parent may have been interrupted before it noted one
            if digest in self.data:
                self.data.pop(digest).release()
        buffer = self.context.buffer(reserve=request.size)
        try:
            buffer.write(self.arena.view(0, request.size))
            self.check()  # out of memory, for one
        except BaseException:
            buffer.release()
            raise
        self.data[request.digest] = buffer

    def compute(self, request: Compute) -> None:
        program = self.program(request)
        set_uniforms(program.members, request.uniforms)
        self.bind(request)
        output = self.buffer(0, request.output)
        output.clear()  # buffers are reused: what a shader does not write is 0, not the last call's
        program.members.run(*request.groups)
        self.context.memory_barrier()
        output.read_into(self.arena.view(0, request.output), request.output)

    def render(self, request: Render) -> None:
        program = self.program(request)
        set_uniforms(program.members, request.uniforms)
        self.bind(request)
        old = self.picture
        if old is None or old.size != request.size:
            self.picture = self.context.framebuffer([self.context.renderbuffer(request.size)])
        assert self.picture is not None
        self.picture.use()
        if old is not None and old is not self.picture:  # only now is it no longer the one in use
            for attachment in old.color_attachments:
                attachment.release()
            old.release()
        self.picture.clear()
        assert program.corners is not None
        program.corners.render(moderngl.TRIANGLES, vertices=3)
        size = 4 * request.size[0] * request.size[1]
        self.picture.read_into(self.arena.view(0, size), components=4)

    def program(self, request: Compute | Render) -> Program:
        """The compiled shader of a request, from the cache where it has been seen before."""
        key = (type(request), request.shader)
        program = self.programs.pop(key, None) or self.compile(request)
        self.programs[key] = program
        if len(self.programs) > PROGRAMS:
            self.programs.popitem(last=False)[1].release()
        return program

    def compile(self, request: Compute | Render) -> Program:
        self.compiled += 1
        try:
            if isinstance(request, Compute):
                return Program(self.context.compute_shader(request.shader))
            members = self.context.program(vertex_shader=CORNERS, fragment_shader=request.shader)
            return Program(members, self.context.vertex_array(members, []))
        except moderngl.Error as error:
            raise Refused("the shader does not compile", str(error)) from None

    def bind(self, request: Compute | Render) -> None:
        """Copy the inputs from the arena to the buffers 1, 2, ... and bind the kept data after them."""
        sizes = request.inputs
        for binding, (offset, size) in enumerate(zip(offsets(sizes), sizes, strict=False), start=1):
            self.buffer(binding, size).write(self.arena.view(offset, size))
        for binding, digest in enumerate(request.data, start=1 + len(sizes)):
            self.data[digest].bind_to_storage_buffer(binding)

    def buffer(self, binding: int, size: int) -> moderngl.Buffer:
        """The storage buffer of `size` bytes at a binding point, reused where the last one there had that size."""
        buffer = self.buffers.get(binding)
        if buffer is None or buffer.size != size:
            if buffer is not None:
                buffer.release()
            buffer = self.buffers[binding] = self.context.buffer(reserve=size)
        buffer.bind_to_storage_buffer(binding)
        return buffer


def set_uniforms(program: Any, uniforms: Mapping[str, NDArray[Any]]) -> None:
    """Give a program its uniforms; those that the driver optimised away are skipped."""
    for name, value in uniforms.items():
        found = program.get(name, None)
        if not isinstance(found, moderngl.Uniform):
            continue
        uniform: Any = found  # moderngl's stubs do not know its `fmt`
        wanted = uniform.dimension * uniform.array_length
        # a driver shortens an array to the elements that are used: only in a vector are too many numbers a mistake
        vector = uniform.array_length == 1 and uniform.dimension > 1 and value.ndim < 2
        if value.size < wanted or (vector and value.size > wanted):
            raise Refused(f"the uniform {name} has {wanted} numbers, {value.size} were given")
        uniform.write(value.reshape(-1)[:wanted].astype(NUMBERS[uniform.fmt[-1]]).tobytes())


def hold_lifeline() -> None:
    """Let the kernel end this process when the parent closes the other end of standard input."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which then ends us
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(0, fcntl.F_SETFL, fcntl.fcntl(0, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([0], [], [], 0)[0]:  # it was closed before we listened
        os._exit(0)


def main(socket: int, arena: int, driver: str) -> None:
    connection = Connection(socket)
    try:
        state = DriverState(driver, Arena(arena))
        connection.send(state.info)
    except Exception as error:  # whatever a driver's loader throws is a reason to report
        connection.send(Failed(f"{driver}: {error}"))
        return
    while True:
        connection.send(state.answer(connection.recv()))


if __name__ == "__main__":
    hold_lifeline()
    with contextlib.suppress(EOFError, OSError):  # the parent is gone
        main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3])
    os._exit(0)  # drivers have been seen to hang while they tidy up
