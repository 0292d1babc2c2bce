"""The linear system: conjugate gradients, preconditioned by multigrid.

For order 2 the first coarser level are the elements of order 1 on the same mesh, whose space lies in theirs: an
eighth of the
unknowns, known exactly, without an aggregate formed on the large matrix. From there on it is smoothed aggregation
with the six rigid motions as near-nullspace (Vanek, Mandel and Brezina 1996; pyamg). docs/decisions/0016 has what
that saves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from porelang.compiled import compiled
from porelang.fea.assemble import Blocks, Longs
from porelang.fea.nodes import Nodes
from porelang.fea.problem import Floats, Ints, Mask
from porelang.progress import tell

#: Iterations that show no progress for that long are begun anew, so often; this many in all are given up.
_PATIENCE, _AGAIN, MOST = 100, 2, 2000
#: Chebyshev's polynomial, and from which part of the largest eigenvalue on it is small: what lies below is left to
#: order 1.
_DEGREE, _LEAST = 2, 0.1
#: Steps that find the largest eigenvalue.
_LANCZOS = 15


@dataclass(frozen=True, slots=True)
class Outcome:
    """What conjugate gradients found: x (k, 3), the norm of what it leaves of the right side, after how many
    iterations; `off` is about the energy (N mm, twice) of its error, as the preconditioner has it."""

    x: Floats
    left: float
    iterations: int
    off: float


def gradients(
    matrix: Blocks, right: Floats, precondition: Callable[[Floats], Floats], wanted: float, start: Floats | None = None
) -> Outcome:
    """Solve for x (k, 3) until the norm of the true residual is `wanted`, or no more progress is made: who asks sees
    what is left. Errors: CancelledError."""
    x = np.zeros_like(right) if start is None else start.copy()
    r = right.copy() if start is None else right - matrix @ x
    first = left = _norm(r)
    if left <= wanted:  # or supports take all of it
        return Outcome(x, left, 0, 0.0)
    best, best_at, begun = np.inf, 0, 0
    direction = np.zeros_like(r)
    last: float | None = None
    iteration = 0
    while iteration < MOST:
        z = precondition(r)
        product = _dot(r, z)
        direction = z if last is None else z + (product / last) * direction
        image = matrix @ direction
        curve = _dot(direction, image)
        stuck = not (np.isfinite(curve) and curve > 0 and product > 0)
        if not stuck:
            iteration += 1
            step = product / curve
            x += step * direction
            r -= step * image
            last, left = product, _norm(r)
            if left < 0.9 * best:
                best, best_at = left, iteration
            stuck = iteration - best_at > _PATIENCE
        if left <= wanted or stuck:  # rounding parts r from what is left in truth: seen, and begun anew from where x is
            r, last = right - matrix @ x, None
            left = _norm(r)
            if left <= wanted or begun == _AGAIN:
                break
            best, best_at, begun = np.inf, iteration, begun + 1
        tell(max(0, min(99, int(100 * np.log(left / first) / np.log(min(wanted / first, 0.5))))), 100)
    r = right - matrix @ x
    return Outcome(x, _norm(r), iteration, abs(_dot(r, precondition(r))))


def _dot(a: Floats, b: Floats) -> float:
    """A sum in one order: that of BLAS depends on its threads, which wait for each other on a busy machine."""
    return float(np.einsum("ni,ni->", a, b))


def _norm(a: Floats) -> float:
    return float(np.sqrt(_dot(a, a)))


def aggregated(matrix: Blocks, modes: Floats) -> Callable[[Floats], Floats]:
    """Smoothed aggregation on a matrix, one V cycle; `modes` (n, 3, 6) are its near-nullspace."""
    import pyamg

    levels = pyamg.smoothed_aggregation_solver(
        matrix.to_scipy(), B=modes.reshape(-1, 6), symmetry="symmetric", strength=("symmetric", {"theta": 0.0}),
        smooth=("energy", {"maxiter": 3}), improve_candidates=None,
        presmoother=("gauss_seidel", {"sweep": "symmetric"}), postsmoother=("gauss_seidel", {"sweep": "symmetric"}),
        max_coarse=300, coarse_solver=_direct(), keep=False,
    )  # fmt: skip

    def cycle(level: int, right: Any) -> Any:
        here = levels.levels[level]
        if level == len(levels.levels) - 1:
            return levels.coarse_solver(here.A, right)
        x = np.zeros_like(right)
        here.presmoother(here.A, x, right)
        x += here.P @ cycle(level + 1, here.R @ (right - here.A @ x))
        here.postsmoother(here.A, x, right)
        return x

    return lambda r: np.asarray(cycle(0, r.ravel())).reshape(r.shape)


def _direct() -> Callable[[Any, Any], Any]:
    """A solver for the coarsest matrix, which is factored once; rows of aggregates that are held are empty, and stay
    so."""
    from scipy.sparse import csc_matrix, diags
    from scipy.sparse.linalg import splu

    factors: list[Any] = []

    def solved(matrix: Any, right: Any) -> Any:
        if not factors:
            diagonal = matrix.diagonal()
            empty = diagonal <= 1e-12 * diagonal.max()
            factors.append(splu(csc_matrix(matrix + diags(np.where(empty, diagonal.max(), 0.0)))))
        return factors[0].solve(np.ravel(right)).reshape(np.shape(right))

    return solved


def nested(matrix: Blocks, nodes: Nodes, held: Mask, coarse: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    """One V cycle for order 2: Chebyshev's polynomial of block Jacobi before and after a correction in order 1.

    Gauss-Seidel takes a quarter more iterations than this one and cannot be shared by threads.
    """
    count = nodes.vertices
    first, second = nodes.edges[:, 0], nodes.edges[:, 1]
    inverse = inverted(matrix.indptr, matrix.indices, matrix.data)
    free = ~held
    largest = 1.1 * _largest(matrix, inverse, free)
    middle, half = (1 + _LEAST) / 2 * largest, (1 - _LEAST) / 2 * largest

    def smooth(x: Floats, rest: Floats) -> None:
        """Improve x, which leaves `rest`; `rest` is used up."""
        change, image = np.zeros_like(x), np.empty_like(x)
        ratio = half / middle
        advance(inverse, rest, change, x, 0.0, 1 / middle)
        for _ in range(_DEGREE - 1):
            matrix.into(change, image)
            rest -= image
            after = 1 / (2 * middle / half - ratio)
            advance(inverse, rest, change, x, after * ratio, 2 * after / half)
            ratio = after

    def cycle(r: Floats) -> Floats:
        x = np.zeros_like(r)
        smooth(x, r.copy())
        low = restrict(nodes.edges, (r - matrix @ x) * free, count) * free[:count]
        correction = coarse(low) * free[:count]
        x[:count] += correction
        x[count:] += (correction[first] + correction[second]) / 2 * free[count:]
        smooth(x, r - matrix @ x)
        return x

    return cycle


def _largest(matrix: Blocks, inverse: Floats, free: Mask) -> float:
    """The largest eigenvalue of the matrix over its diagonal blocks: that of Lanczos' tridiagonal matrix, whose entries
    are the factors of conjugate gradients (Golub and Van Loan, Matrix Computations, 10.2), and what it leaves.

    Steps of the power method came to three quarters of it where tetrahedra are long: what is smooth is then amplified
    by Chebyshev's polynomial, and the iterations end at once.
    """
    r = np.cos(np.arange(free.size, dtype=np.float64) ** 2 % 6.0).reshape(free.shape) * free
    z = np.einsum("nij,nj->ni", inverse, r)
    direction, product = z.copy(), _dot(r, z)
    steps: list[float] = []
    ratios: list[float] = []
    while len(steps) < _LANCZOS:
        image = matrix @ direction
        curve = _dot(direction, image)
        if not curve > 0:
            break
        steps.append(product / curve)
        r -= steps[-1] * image
        z = np.einsum("nij,nj->ni", inverse, r)
        last, product = product, _dot(r, z)
        ratios.append(max(product, 0.0) / last)
        direction = z + ratios[-1] * direction
    if not steps:
        return 1.0
    alpha, beta = np.array(steps), np.array(ratios)
    diagonal = 1 / alpha
    diagonal[1:] += beta[:-1] / alpha[:-1]
    beside = np.sqrt(beta) / alpha
    values, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(beside[:-1], 1) + np.diag(beside[:-1], -1))
    return float(values[-1] + abs(beside[-1] * vectors[-1, -1]))


@compiled
def inverted(indptr: Longs, indices: Ints, data: Floats) -> Floats:
    """The inverses (n, 3, 3) of the blocks on the diagonal."""
    out = np.zeros((len(indptr) - 1, 3, 3))
    for row in range(len(out)):
        for at in range(indptr[row], indptr[row + 1]):
            if indices[at] == row:
                d = data[at]
                for i in range(3):
                    j, k = (i + 1) % 3, (i + 2) % 3
                    for c in range(3):
                        m, n = (c + 1) % 3, (c + 2) % 3
                        out[row, c, i] = d[j, m] * d[k, n] - d[j, n] * d[k, m]
                det = d[0, 0] * out[row, 0, 0] + d[0, 1] * out[row, 1, 0] + d[0, 2] * out[row, 2, 0]
                for i in range(3):
                    for c in range(3):
                        out[row, i, c] /= det
    return out


@compiled
def advance(inverse: Floats, rest: Floats, change: Floats, x: Floats, keep: float, add: float) -> None:
    """One step of Chebyshev's iteration: the change is `keep` of the last one and `add` of what the blocks make of
    `rest`."""
    for row in range(len(x)):
        for i in range(3):
            d = (
                inverse[row, i, 0] * rest[row, 0]
                + inverse[row, i, 1] * rest[row, 1]
                + inverse[row, i, 2] * rest[row, 2]
            )
            change[row, i] = keep * change[row, i] + add * d
            x[row, i] += change[row, i]


@compiled
def restrict(edges: Ints, r: Floats, count: int) -> Floats:
    """Residuals of vertices and middles of edges on the vertices alone: the transpose of interpolation."""
    out = r[:count].copy()
    for e in range(len(edges)):
        for i in range(3):
            half = r[count + e, i] / 2
            out[edges[e, 0], i] += half
            out[edges[e, 1], i] += half
    return out
