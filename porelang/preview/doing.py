"""Work for one who looks: they are told how far it is, that it has ended, and what was wrong."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from porelang.diagnostics import Diagnostic, PoreError, render
from porelang.failures import failure
from porelang.preview.scene import QUICK, Scene, Wish, scene
from porelang.preview.words import on_page
from porelang.program import Design
from porelang.progress import CancelledError, checkpoint
from porelang.render.cells import BUDGET
from porelang.session.jobs import Job, Jobs

#: What somebody who looks is told: an object for JSON, or a scene.
Message = dict[str, Any] | Scene
Tell = Callable[[Message], None]
#: Seconds between two words about how far a job has come.
OFTEN = 0.1


def refusal(purpose: str, diagnostics: Sequence[Diagnostic]) -> dict[str, Any]:
    """What is told of errors."""
    text = "\n\n".join(render(on_page(d)) for d in diagnostics)
    return {"say": "refused", "of": purpose, "text": text}


def begin(jobs: Jobs, purpose: str, work: Callable[[], None], tell: Tell, said: str = "") -> Job[None]:
    """Begin a job, of which the latest of its purpose wins; `said` is what is being done, in place of its own words."""
    last = 0.0

    def report(what: str, done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= OFTEN:
            last = now
            tell({"say": "doing", "of": purpose, "what": said or what, "share": done / max(total, 1)})

    def whole() -> None:
        try:
            work()
        except CancelledError:  # `done` is what is told
            raise
        except PoreError as error:
            tell(refusal(purpose, error.diagnostics))
        except Exception as error:  # nobody asks for the result of a job
            tell(refusal(purpose, [failure(error)]))
        finally:
            tell({"say": "done", "of": purpose})

    return jobs.submit(purpose, whole, report)


def draw(design: Design, wish: Wish, tell: Tell) -> Scene:
    """Tell the scene of a design: one first that is there sooner and drawn more slowly. Errors: those of `scene`."""
    for budget in (QUICK, BUDGET):
        made = scene(design, wish, budget)
        checkpoint()
        tell(made)
        checkpoint()
    return made
