"""The GPU as a child process: it computes, and whatever becomes of the driver, the caller sees a clean error."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porelang
from porelang.gpu import Gpu, GpuFailed, GpuMissing, open_gpu, shared_gpu
from porelang.gpu import errors as gpu_errors
from porelang.render.picture import Wishes, render_output
from porelang.resources import PACKAGE

SCALE = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
layout(std430, binding = 1) readonly buffer In { float a[]; };
uniform float k;
uniform vec3 v;
uniform int n;
uniform uint bits;
uniform bool on;
uniform mat2 m;
uniform float w[4];
uniform float unused;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(o.length())) return;
    o[i] = k * a[i] + v.y + float(n) + float(bits >> 31) + (on ? 0.5 : 0.0) + m[1].x + w[2];
}
"""
INDEX = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
void main() { uint i = gl_GlobalInvocationID.x; if (i < uint(o.length())) o[i] = float(i); }
"""
# Mesa leaves the loops of an invocation after 65535 rounds, so the work is in the number of groups: days of it
ENDLESS = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
uniform uint seed;
void main() {
    uint h = seed + gl_GlobalInvocationID.x;
    for (uint j = 0u; j < 60000u; j++) { h = h * 747796405u + 2891336453u; h ^= h >> 13; }
    o[gl_LocalInvocationIndex] = float(h);
}
"""
DAYS = (65535, 65535, 1)
GOOD: dict[str, Any] = {
    "k": 2.0,
    "v": [1, 10, 100],
    "n": 3,
    "bits": 2**32 - 1,
    "on": True,
    "m": np.eye(2),
    "w": range(4),
}


@pytest.fixture(params=["egl", "osmesa"], scope="module")
def gpu(request: pytest.FixtureRequest, opened: Callable[..., Gpu]) -> Iterator[Gpu]:
    with opened(request.param) as device:
        yield device


def scaled(gpu: Gpu, count: int = 1000, k: float = 2.0) -> None:
    a = np.linspace(-1, 1, count, dtype=np.float32)
    uniforms = {**GOOD, "unused": 1, "k": k}
    got = gpu.compute(SCALE, output=count, inputs=[a], uniforms=uniforms, groups=(-(-count // 64), 1, 1))
    np.testing.assert_allclose(got, k * a + 10 + 3 + 1 + 0.5 + 0 + 2, atol=4e-6)


def ended(pid: int) -> bool:
    """Whether a process is gone, waiting for it a while."""
    for _ in range(200):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            return True
        if state == "Z" and os.getppid() != 1:  # only its own parent could leave a zombie, and it is dead or is us
            return True
        time.sleep(0.05)
    return False


def test_info_names_the_device_and_its_limits(gpu: Gpu) -> None:
    info = gpu.info
    assert info.driver in ("egl", "osmesa")
    assert info.renderer
    assert float(info.glsl) >= 4.3
    assert info.max_buffer_bytes >= 2**27  # what OpenGL 4.3 guarantees is 2^24; Mesa gives 2^27
    assert min(info.max_groups) >= 65535


def test_compute_reads_inputs_and_uniforms_of_every_type(gpu: Gpu) -> None:
    scaled(gpu)
    scaled(gpu, 777)


def test_integer_inputs_keep_their_bits(gpu: Gpu) -> None:
    shader = """#version 430
    layout(local_size_x = 1) in;
    layout(std430, binding = 0) buffer Out { float o[]; };
    layout(std430, binding = 1) readonly buffer A { uint a[]; };
    layout(std430, binding = 2) readonly buffer B { int b[]; };
    void main() { uint i = gl_GlobalInvocationID.x; o[i] = float(a[i] >> 24) + float(b[i]); }
    """
    a = np.array([0xFF000000, 0x01FFFFFF, 7], np.uint32)
    b = np.array([-300, 4, -1], np.int32)
    assert gpu.compute(shader, output=3, inputs=[a, b], groups=(3, 1, 1)).tolist() == [-45.0, 5.0, -1.0]


def test_strided_inputs_are_read_in_their_order(gpu: Gpu) -> None:
    shader = INDEX.replace("void main", "layout(std430, binding = 1) readonly buffer In { float a[]; };\nvoid main")
    a = np.arange(200, dtype=np.float32).reshape(10, 20)
    got = gpu.compute(shader.replace("float(i);", "a[i];"), output=100, inputs=[a[:, ::2]], groups=(2, 1, 1))
    np.testing.assert_array_equal(got, a[:, ::2].ravel())


def test_what_a_shader_leaves_unwritten_is_zero_although_buffers_are_reused(gpu: Gpu) -> None:
    assert gpu.compute(INDEX, output=640, groups=(10, 1, 1))[-1] == 639
    assert not gpu.compute(INDEX, output=640, groups=(1, 1, 1))[64:].any()


def test_a_uniform_change_compiles_nothing(gpu: Gpu) -> None:
    scaled(gpu)
    before = gpu.compiled
    for k in np.linspace(0.1, 3, 8):
        scaled(gpu, k=float(k))
    assert gpu.compiled == before
    gpu.compute(INDEX + "// another\n", output=4, groups=(1, 1, 1))
    assert gpu.compiled == before + 1


def test_many_shaders_do_not_pile_up(gpu: Gpu) -> None:
    sources = [INDEX.replace("float(i)", f"float(i) + {n}.0") for n in range(70)]
    for n, source in enumerate(sources):
        assert gpu.compute(source, output=2, groups=(1, 1, 1))[1] == n + 1
    before = gpu.compiled
    gpu.compute(sources[-1], output=2, groups=(1, 1, 1))
    assert gpu.compiled == before
    gpu.compute(sources[0], output=2, groups=(1, 1, 1))
    assert gpu.compiled == before + 1


def test_millions_of_points_come_back_whole(gpu: Gpu) -> None:
    count = 4_600_000
    got = gpu.compute(INDEX.replace("64", "256"), output=count, groups=(-(-count // 256), 1, 1))
    np.testing.assert_array_equal(got, np.arange(count, dtype=np.float32))


def test_a_picture_has_its_top_row_first(gpu: Gpu) -> None:
    fragment = """#version 330
    uniform vec2 size;
    out vec4 colour;
    void main() { colour = vec4(gl_FragCoord.xy / size, 0.25, 1.0); }
    """
    for width, height in ((8, 4), (5, 7)):
        picture = gpu.render(fragment, size=(width, height), uniforms={"size": (width, height)})
        x, y = np.meshgrid((np.arange(width) + 0.5) / width, 1 - (np.arange(height) + 0.5) / height)
        want = 255 * np.stack([x, y, np.full_like(x, 0.25), np.ones_like(x)], axis=-1)
        assert picture.shape == (height, width, 4)
        assert picture.dtype == np.uint8
        assert abs(picture - want).max() <= 0.5001


def test_a_compile_error_carries_the_log_and_harms_nothing(gpu: Gpu) -> None:
    with pytest.raises(GpuFailed, match="does not compile") as caught:
        gpu.compute(INDEX.replace("float(i)", "flaot(i)"), output=4, groups=(1, 1, 1))
    assert "flaot" in caught.value.log
    with pytest.raises(GpuFailed, match="does not compile"):
        gpu.render("#version 330\nvoid main() { nonsense }", size=(4, 4))
    scaled(gpu)


@pytest.mark.slow
def test_a_killed_child_is_a_clean_error_and_the_next_call_works(gpu: Gpu) -> None:
    killer = threading.Timer(0.5, os.kill, (gpu.pid, signal.SIGKILL))
    killer.start()
    with pytest.raises(GpuFailed, match=r"process was killed \(SIGKILL\)"):
        gpu.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS)
    scaled(gpu)
    os.kill(gpu.pid, signal.SIGKILL)  # between two calls
    with pytest.raises(GpuFailed, match="process was killed"):
        scaled(gpu)
    scaled(gpu)


@pytest.mark.slow
def test_a_shader_that_never_ends_is_stopped(gpu: Gpu) -> None:
    pid = gpu.pid
    with pytest.raises(GpuFailed, match=r"did not finish within 0\.5 s"):
        gpu.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS, timeout=0.5)
    assert not Path(f"/proc/{pid}").exists()
    scaled(gpu)


@pytest.mark.parametrize(
    ("request_", "error", "message"),
    [
        ({"output": 2**28}, GpuFailed, "smaller pieces"),
        ({"output": 0}, GpuFailed, "the output has 0 bytes"),
        ({"groups": (2**20, 1, 1)}, GpuFailed, "work groups"),
        ({"groups": (0, 1, 1)}, GpuFailed, "work groups"),
        ({"inputs": [np.zeros(4)]}, TypeError, "float64"),
        ({"inputs": []}, None, ""),
        ({"uniforms": {**GOOD, "v": [1, 2]}}, GpuFailed, "uniform v has 3 numbers, 2 were given"),
        ({"uniforms": {**GOOD, "v": [1, 2, 3, 4]}}, GpuFailed, "uniform v has 3 numbers, 4 were given"),
        ({"uniforms": {"k": "2"}}, TypeError, "uniform k"),
    ],
)
def test_impossible_requests_are_refused(
    gpu: Gpu, request_: dict[str, object], error: type[Exception] | None, message: str
) -> None:
    asked = {"output": 4, "inputs": [np.ones(4, np.float32)], "uniforms": GOOD, "groups": (1, 1, 1), **request_}
    if error is not None:
        with pytest.raises(error, match=message):
            gpu.compute(SCALE, **asked)  # type: ignore[arg-type]
    scaled(gpu)


def test_threads_share_a_device(gpu: Gpu) -> None:
    wrong: list[int] = []

    def work(count: int) -> None:
        for _ in range(5):
            got = gpu.compute(INDEX, output=count, groups=(-(-count // 64), 1, 1))
            if not np.array_equal(got, np.arange(count)):
                wrong.append(count)

    threads = [threading.Thread(target=work, args=(n,)) for n in (100, 1000, 5000)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


DATA = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Out { float o[]; };
layout(std430, binding = 1) readonly buffer In { float a[]; };
layout(std430, binding = 2) readonly buffer Grid { uint grid[]; };
layout(std430, binding = 3) readonly buffer Bars { uint bars[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(o.length())) o[i] = a[i] + uintBitsToFloat(grid[i]) + float(bars[i]);
}
"""


class Source:
    """Data of a digest that count how often they were asked for."""

    def __init__(self, digest: str, words: np.ndarray) -> None:
        self.digest, self.words, self.asked = digest, words, 0

    @property
    def data(self) -> tuple[str, Callable[[], np.ndarray]]:
        return self.digest, self.get

    def get(self) -> np.ndarray:
        self.asked += 1
        return self.words


def sources(name: str, count: int = 100) -> tuple[Source, Source]:
    grid = np.arange(count, dtype=np.float32) / 4
    bars = np.arange(count, dtype=np.uint32)[::-1]
    return Source(f"{name} grid", grid.view(np.uint32)), Source(f"{name} bars", bars)


def added(gpu: Gpu, grid: Source, bars: Source, count: int = 100) -> None:
    a = np.full(count, 1000, np.float32)
    got = gpu.compute(DATA, output=count, inputs=[a], data=[grid.data, bars.data], groups=(-(-count // 64), 1, 1))
    np.testing.assert_array_equal(got, 1000 + grid.words.view(np.float32) + bars.words)


def test_data_are_sent_once_and_again_after_a_crash(gpu: Gpu) -> None:
    grid, bars = sources("once")
    other = Source("once other grid", grid.words + np.uint32(1 << 20))
    for _ in range(3):
        added(gpu, grid, bars)
    added(gpu, other, bars)
    scaled(gpu)  # binds other buffers in their place
    added(gpu, grid, bars)
    assert (grid.asked, bars.asked, other.asked) == (1, 1, 1)
    os.kill(gpu.pid, signal.SIGKILL)
    with pytest.raises(GpuFailed, match="killed"):
        added(gpu, grid, bars)
    added(gpu, grid, bars)
    assert (grid.asked, bars.asked, other.asked) == (2, 2, 1)


def test_one_digest_may_be_bound_twice_and_read_by_pictures(gpu: Gpu) -> None:
    words = Source("twice", np.full(100, 51, np.uint32))
    fragment = """#version 430
    layout(std430, binding = 1) readonly buffer A { uint a[]; };
    layout(std430, binding = 2) readonly buffer B { uint b[]; };
    out vec4 colour;
    void main() { colour = vec4(float(a[0]) / 255.0, float(b[99]) / 255.0, 0.0, 1.0); }
    """
    for _ in range(2):
        picture = gpu.render(fragment, size=(3, 2), data=[words.data, words.data])
        assert picture.tolist() == [[[51, 51, 0, 255]] * 3] * 2
    assert words.asked == 1


def test_the_least_recently_used_data_make_room(gpu: Gpu, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gpu._child.resident, "most", 4 * 350)
    first, bars = sources("room 1")
    second, _ = sources("room 2")
    third, _ = sources("room 3")
    for grid in (first, second, first, third):  # 400 words: the second has to go
        added(gpu, grid, bars)
    added(gpu, first, bars)
    assert (first.asked, second.asked, third.asked, bars.asked) == (1, 1, 1, 1)
    added(gpu, second, bars)  # and now the third
    added(gpu, first, bars)
    assert (first.asked, second.asked, third.asked, bars.asked) == (1, 2, 1, 1)
    large, larger = sources("room 4", 400)
    for _ in range(2):  # more than there is room for: what one call needs is kept all the same
        added(gpu, large, larger, 400)
    assert (large.asked, larger.asked) == (1, 1)
    added(gpu, first, bars)
    assert (first.asked, bars.asked) == (2, 2)


def test_data_may_be_made_with_the_same_gpu(gpu: Gpu) -> None:
    grid, bars = sources("nested")

    def baked() -> np.ndarray:
        added(gpu, grid, bars)
        return grid.words

    a = np.zeros(100, np.float32)
    data = [("nested baked", baked), bars.data]
    got = gpu.compute(DATA, output=100, inputs=[a], data=data, groups=(2, 1, 1))
    np.testing.assert_array_equal(got, grid.words.view(np.float32) + bars.words)


def test_data_that_cannot_be_made_or_kept_harm_nothing(gpu: Gpu, monkeypatch: pytest.MonkeyPatch) -> None:
    grid, bars = sources("harm")

    def broken() -> np.ndarray:
        raise KeyError("no such file")

    def call(first: Any) -> None:
        gpu.compute(DATA, output=100, inputs=[np.zeros(100, np.float32)], data=[first, bars.data], groups=(2, 1, 1))

    with pytest.raises(KeyError, match="no such file"):
        call(("harm broken", broken))
    with pytest.raises(TypeError, match="binding 2 is float64"):
        call(("harm float64", lambda: np.zeros(100)))
    large = np.broadcast_to(np.uint32(1), (gpu.info.max_buffer_bytes // 4 + 1,))
    with pytest.raises(GpuFailed, match="the buffer at binding 2 has 134217732 bytes, a buffer of this device"):
        call(("harm large", lambda: large))

    def full(size: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(gpu._child.arena, "grow", full)
        with pytest.raises(GpuFailed, match="no memory to share"):
            added(gpu, grid, bars)
    added(gpu, grid, bars)


def test_more_buffers_than_the_device_binds_are_refused(gpu: Gpu) -> None:
    most = gpu.info.max_buffers
    assert most >= 8  # what OpenGL 4.3 guarantees
    one = np.ones(1, np.float32)
    data = [(f"one of many {i}", lambda: one.view(np.uint32)) for i in range(most)]
    blocks = "".join(f"layout(std430, binding = {i}) buffer B{i} {{ float b{i}[]; }};\n" for i in range(1, most))
    total = " + ".join(f"b{i}[0]" for i in range(1, most))
    shader = f"""#version 430
    layout(local_size_x = 1) in;
    layout(std430, binding = 0) buffer Out {{ float o[]; }};
    {blocks}
    void main() {{ o[0] = {total}; }}
    """
    assert gpu.compute(shader, output=1, data=data[1:], groups=(1, 1, 1)).tolist() == [most - 1]
    with pytest.raises(GpuFailed, match=f"has {most + 1} storage buffers, this device binds at most {most}"):
        gpu.compute(shader, output=1, data=data, groups=(1, 1, 1))
    with pytest.raises(GpuFailed, match=f"has {most + 1} storage buffers"):
        gpu.render("", size=(1, 1), inputs=[one], data=data)


def test_what_a_person_waits_for_does_not_wait_for_long_work(opened: Callable[..., Gpu]) -> None:
    opened().close()
    work, person = shared_gpu(), shared_gpu(lane="person")
    assert work is shared_gpu(lane="work")
    assert person is shared_gpu(lane="person")
    assert work.pid != person.pid
    stop = threading.Event()
    ended: list[str] = []

    def long() -> None:
        try:
            work.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS, timeout=600, cancel=stop.is_set)
        except CancelledError:
            ended.append("work")

    thread = threading.Thread(target=long)
    thread.start()
    time.sleep(0.3)  # into the shader
    try:
        scaled(person)
        picture = render_output(porelang.compile("sphere(5mm)").design(), None, Wishes((32, 24), samples=1))
        assert picture.covered > 0
        assert not ended
        assert thread.is_alive()
    finally:
        stop.set()
        thread.join()
    assert ended == ["work"]
    scaled(work)


def test_a_cancelled_shader_is_stopped_and_the_next_call_works(gpu: Gpu) -> None:
    scaled(gpu)
    pid, stop = gpu.pid, threading.Event()
    threading.Timer(0.3, stop.set).start()
    with pytest.raises(CancelledError):
        gpu.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS, cancel=stop.is_set)
    assert not Path(f"/proc/{pid}").exists()
    with pytest.raises(CancelledError):
        gpu.compute(INDEX, output=4, groups=(1, 1, 1), cancel=stop.is_set)
    assert gpu.compute(INDEX, output=2, groups=(1, 1, 1), cancel=lambda: False).tolist() == [0, 1]
    scaled(gpu)


def test_a_call_that_waits_for_its_turn_can_be_cancelled(gpu: Gpu) -> None:
    scaled(gpu)
    pid, first, asked = gpu.pid, threading.Event(), 0

    def long() -> None:
        with pytest.raises(CancelledError):
            gpu.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS, cancel=first.is_set)

    def second() -> bool:
        nonlocal asked
        asked += 1
        return asked > 2

    thread = threading.Thread(target=long)
    thread.start()
    time.sleep(0.3)
    with pytest.raises(CancelledError):
        gpu.compute(INDEX, output=4, groups=(1, 1, 1), cancel=second)
    assert gpu.pid == pid  # the other's shader goes on
    assert thread.is_alive()
    first.set()
    thread.join()
    scaled(gpu)


def test_a_timeout_holds_for_calls_that_can_be_cancelled(gpu: Gpu) -> None:
    with pytest.raises(GpuFailed, match=r"did not finish within 0\.3 s"):
        gpu.compute(ENDLESS, output=64, uniforms={"seed": 1}, groups=DAYS, timeout=0.3, cancel=lambda: False)
    scaled(gpu)


def test_closing_ends_the_child_and_frees_its_files(opened: Callable[..., Gpu]) -> None:
    before = len(os.listdir("/proc/self/fd"))
    gpu = opened()
    pid = gpu.pid
    gpu.close()
    gpu.close()
    assert not Path(f"/proc/{pid}").exists()  # not even a zombie
    assert len(os.listdir("/proc/self/fd")) == before
    with pytest.raises(GpuFailed, match="closed"):
        gpu.compute(INDEX, output=4, groups=(1, 1, 1))


def python(code: str) -> subprocess.Popen[str]:
    """A Python of its own that runs `code`, as a program of a user would; in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(PACKAGE.parent)},
        start_new_session=True,
    )


@pytest.fixture
def opengl(opened: Callable[..., Gpu]) -> None:
    """For tests whose scripts open a GPU themselves."""
    opened().close()


@pytest.mark.usefixtures("opengl")
def test_one_gpu_is_shared_by_a_process() -> None:
    script = python(f"""
        from porelang.gpu import shared_gpu
        gpu = shared_gpu()
        assert shared_gpu() is gpu
        gpu.close()
        again = shared_gpu()
        assert again is not gpu
        print(again.compute({INDEX!r}, output=2, groups=(1, 1, 1)).tolist())
    """)
    out, err = script.communicate(timeout=120)
    assert out.strip() == "[0.0, 1.0]", err


@pytest.mark.usefixtures("opengl")
def test_a_script_without_a_main_guard_works_and_leaves_nothing_behind() -> None:
    script = python(f"""
        from porelang.gpu import open_gpu
        gpu = open_gpu()
        print(gpu.pid, gpu.compute({INDEX!r}, output=3, groups=(1, 1, 1)).tolist())
    """)
    out, err = script.communicate(timeout=120)
    pid, _, numbers = out.partition(" ")
    assert numbers.strip() == "[0.0, 1.0, 2.0]", err
    assert err == ""
    assert ended(int(pid))


LANES = f"""
import os, signal, subprocess, sys, threading, time
from porelang.gpu import shared_gpu
lanes = [shared_gpu(), shared_gpu(lane="person")]
def busy(gpu):
    try:
        gpu.compute({ENDLESS!r}, output=64, uniforms={{"seed": 1}}, groups={DAYS}, timeout=600)
    except Exception:
        pass  # the parent ends
def start_work():
    for gpu in lanes:
        threading.Thread(target=busy, args=(gpu,), daemon=True).start()
    time.sleep(1.0)  # into the shader
def say():
    print(*(gpu.pid for gpu in lanes), flush=True)
"""


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("busy", [False, True])
@pytest.mark.parametrize(
    "end",
    [
        "sys.exit()",
        "raise KeyboardInterrupt",
        "os._exit(0)",
        "os.kill(os.getpid(), signal.SIGKILL)",
        "os.kill(os.getpid(), signal.SIGTERM)",
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(143)); os.kill(os.getpid(), signal.SIGTERM); time.sleep(60)",
        "os.execv(sys.executable, [sys.executable, '-c', 'import time; time.sleep(60)'])",
        "os.fork() or time.sleep(60)",
        "subprocess.Popen(['sleep', '60'])",
    ],
    ids=["exit", "ctrl-c", "_exit", "SIGKILL", "SIGTERM", "handler", "exec", "fork", "spawn"],
)
@pytest.mark.slow
def test_both_children_end_with_their_parent(end: str, busy: bool) -> None:
    script = python(LANES + f"{'start_work()' * busy}\nsay()\n{end}\nos._exit(0)\n")
    assert script.stdout is not None
    pids = [int(pid) for pid in script.stdout.readline().split()]
    assert len(pids) == 2
    try:
        assert all(ended(pid) for pid in pids)
    finally:
        os.killpg(script.pid, signal.SIGKILL)  # with the processes that it started
        script.communicate()


@pytest.mark.usefixtures("opengl")
def test_a_forked_process_opens_a_device_of_its_own() -> None:
    script = python(f"""
        import os
        from porelang.gpu import shared_gpu
        gpu, work = shared_gpu(), dict(output=2, groups=(1, 1, 1))
        if (pid := os.fork()) == 0:
            ok = shared_gpu() is not gpu and gpu.compute({INDEX!r}, **work).tolist() == [0, 1]
            shared_gpu().close(), gpu.close()
            os._exit(0 if ok else 1)
        assert os.waitpid(pid, 0)[1] == 0
        print(gpu.compute({INDEX!r}, **work).tolist())
    """)
    out, err = script.communicate(timeout=120)
    assert out.strip() == "[0.0, 1.0]", err


@pytest.mark.usefixtures("opengl")
def test_a_process_forked_while_a_shader_runs_does_not_wait_for_it() -> None:
    script = python(
        LANES
        + f"""
start_work()
if (pid := os.fork()) == 0:
    ok = all(gpu.compute({INDEX!r}, output=2, groups=(1, 1, 1)).tolist() == [0, 1] for gpu in lanes)
    os._exit(0 if ok else 1)
print(os.waitpid(pid, 0)[1], flush=True)
os._exit(0)
"""
    )
    out, err = script.communicate(timeout=120)
    assert out.strip() == "0", err


def test_opengl_that_is_switched_off_is_told_how_to_switch_it_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PORELANG_GL", "none")
    with pytest.raises(GpuMissing) as caught:
        open_gpu()
    assert caught.value.install == "unset PORELANG_GL"
    assert caught.value.install in str(caught.value)
    assert "PORELANG_GL" in caught.value.reason


@pytest.mark.skipif(sys.platform != "linux", reason="no driver is loaded on other systems")
def test_a_driver_library_that_cannot_be_loaded_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("PORELANG_GL", raising=False)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    (tmp_path / "moderngl.py").write_text("raise ImportError('libEGL.so.1: cannot open shared object file')")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(GpuMissing) as caught:
        open_gpu("egl")
    assert "libEGL.so.1" in caught.value.reason
    assert "Traceback" not in str(caught.value)
    assert caught.value.install


def test_the_environment_chooses_the_kind(monkeypatch: pytest.MonkeyPatch, opened: Callable[..., Gpu]) -> None:
    opened("egl").close()
    opened("osmesa").close()
    monkeypatch.setenv("PORELANG_GL", "osmesa")
    with open_gpu() as gpu:
        assert gpu.info.driver == "osmesa"
    with open_gpu("egl") as gpu:  # what the program asks for outweighs it
        assert gpu.info.driver == "egl"
    monkeypatch.setenv("PORELANG_GL", "vulkan")
    with pytest.raises(GpuMissing, match="vulkan"):
        open_gpu()


@pytest.mark.parametrize(
    ("platform", "release", "root", "command"),
    [
        ("linux", "ID=debian\n", True, "apt-get install libegl1 libgl1"),
        ("linux", 'ID=linuxmint\nID_LIKE="ubuntu debian"\n', False, "sudo apt-get install libegl1 libgl1"),
        ("linux", "ID=fedora\n", False, "sudo dnf install mesa-libEGL mesa-dri-drivers"),
        ("linux", "ID=nixos\n", False, "libEGL.so.1"),
        ("darwin", "", False, "macOS"),
    ],
)
def test_the_install_command_fits_the_system(
    monkeypatch: pytest.MonkeyPatch, platform: str, release: str, root: bool, command: str
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(os, "geteuid", lambda: 0 if root else 1000)
    monkeypatch.setattr(Path, "read_text", lambda self, **_: release)
    assert command in gpu_errors.install_command()
    assert gpu_errors.install_command().startswith("sudo") == command.startswith("sudo")
