"""Opening OpenGL 4.3 without a screen: EGL (a graphics card or Mesa), or Mesa's OSMesa library."""

from __future__ import annotations

import ctypes
from types import TracebackType
from typing import Any, ClassVar

import moderngl

VERSION = 430  # the first with compute shaders and storage buffers


def open_context(driver: str) -> moderngl.Context:
    """A current OpenGL context through `egl` or `osmesa`; raises an exception that says what is missing."""
    if driver == "osmesa":
        context: Any = _OSMesa()  # moderngl asks for a loader; its stubs call it something else
        return moderngl.create_context(require=VERSION, context=context)
    backend: Any = "egl"
    return moderngl.create_context(require=VERSION, standalone=True, backend=backend)


class _OSMesa:
    """An OSMesa context as moderngl's loader: it is current from the start and stays so."""

    LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
    ATTRIBUTES: ClassVar[dict[int, int]] = {
        0x22: 0x1908,  # OSMESA_FORMAT: OSMESA_RGBA
        0x33: 0x34,  # OSMESA_PROFILE: OSMESA_CORE_PROFILE
        0x36: VERSION // 100,  # OSMESA_CONTEXT_MAJOR_VERSION
        0x37: VERSION // 10 % 10,  # OSMESA_CONTEXT_MINOR_VERSION
    }
    UNSIGNED_BYTE = 0x1401
    SIDE = 4  # pixels; everything is drawn to buffers of our own, but OSMesa wants one of its own too

    def __init__(self) -> None:
        self.library = self._load()
        create = self.library.OSMesaCreateContextAttribs
        create.restype, create.argtypes = ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_void_p]
        current = self.library.OSMesaMakeCurrent
        current.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_int]
        self.address = self.library.OSMesaGetProcAddress
        self.address.restype, self.address.argtypes = ctypes.c_void_p, [ctypes.c_char_p]
        flat = [number for pair in self.ATTRIBUTES.items() for number in pair]
        context = create((ctypes.c_int * (len(flat) + 2))(*flat, 0, 0), None)
        if not context:
            raise OSError("OSMesa has no OpenGL 4.3")
        self.pixels = (ctypes.c_ubyte * (4 * self.SIDE * self.SIDE))()
        if not current(context, self.pixels, self.UNSIGNED_BYTE, self.SIDE, self.SIDE):
            raise OSError("OSMesa could not make its context current")

    def _load(self) -> ctypes.CDLL:
        for name in self.LIBRARIES:
            try:
                return ctypes.CDLL(name)
            except OSError:
                continue
        raise OSError(f"cannot open {self.LIBRARIES[0]}")

    def load_opengl_function(self, name: str) -> int:
        return self.address(name.encode()) or 0

    def release(self) -> None:
        pass

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        pass
