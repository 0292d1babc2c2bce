"""Blurred fields: linear ones stay, others are what the integral with a Gaussian gives, up to the faces of the box."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.special import erf

import porelang
from porelang.diagnostics import PoreError
from porelang.tasks import blur

Q = np.random.default_rng(2).uniform(-9.9, 9.9, (400, 3))


def of(text: str, points: Any = Q, **more: Any) -> Any:
    return porelang.compile(f"out a = {text}").field("a", **more)(points)


def test_what_is_linear_stays_as_it_is(backend: str) -> None:
    """Everywhere in the box, up to its faces."""
    options: dict[str, Any] = {"backend": backend, "dtype": "f32"} if backend == "glsl" else {}
    tolerance = 1e-4 if backend == "glsl" else 1e-11
    found = of("blur(x + 2 * y - 3 * z + 4, 2.5mm, cube(20))", **options)
    np.testing.assert_allclose(found, Q @ [1, 2, -3] + 4, atol=tolerance)
    faces = np.array([[10.0, 0, 0], [-10, 10, 10], [3, -10, 10]])
    np.testing.assert_allclose(of("blur(x, 2.5mm, cube(20))", faces), faces[:, 0], atol=1e-11)


@pytest.mark.parametrize("voxel", ["", ", voxel=0.5mm", ", voxel=2mm"])
def test_a_wave_is_damped_as_its_integral_says(voxel: str) -> None:
    """exp(-k^2 s^2 / 2) of it is left: the Fourier transform of a Gaussian. Samples err by less than (k h)^2 / 8."""
    k, sigma = 0.6, 2.0
    step = {"": 1.0, ", voxel=0.5mm": 0.5, ", voxel=2mm": 2.0}[voxel]
    found = of(f"blur(sin({k} * x), {sigma}mm, cube(20){voxel})")
    left = np.exp(-0.5 * (k * sigma) ** 2)
    np.testing.assert_allclose(found, left * np.sin(k * Q[:, 0]), atol=left * (k * step) ** 2 / 8 + 2e-4)


def test_a_step_becomes_an_error_function() -> None:
    found = of("blur(if x + 0.25 < 0 then -1 else 1, 2mm, cube(20), voxel=0.5mm)")
    np.testing.assert_allclose(found, erf((Q[:, 0] + 0.25) / (2 * np.sqrt(2))), atol=0.02)


def test_a_square_rises_by_the_variance() -> None:
    """The mean of (x + d)^2 is x^2 + sigma^2; a Gaussian to four deviations has 0.9989 of its variance."""
    found = of("blur(x * x + y, 2mm, cube(20), voxel=0.25mm)")
    np.testing.assert_allclose(found - Q[:, 0] ** 2 - Q[:, 1], 4.0, rtol=5e-3)


def test_it_is_the_filter_that_others_have() -> None:
    """Against SciPy, to four deviations, where that meets no face."""
    values = np.random.default_rng(1).normal(size=(40, 37, 34, 2))
    for sigma in (1.0, 1.7, 4.0):
        weights = blur.gaussian(sigma)
        found, r = blur.averaged(values, weights), len(weights) // 2
        assert found.shape == (40 - 2 * r, 37 - 2 * r, 34 - 2 * r, 2)
        for k in range(2):
            expected = gaussian_filter(values[..., k], sigma, radius=r)
            np.testing.assert_allclose(found[..., k], expected[r:-r, r:-r, r:-r], atol=1e-14)


def test_vectors_are_blurred_by_component_and_settings_count() -> None:
    made = porelang.compile(
        "param s = 1mm in 0.5mm..4mm\nout v = blur([x, sin(y), 2], s, cube(20))\nout w = blur(sin(y), s, cube(20))"
    )
    for s in (1.0, 3.0):
        found = made.field("v", s=s)(Q)
        np.testing.assert_allclose(found[:, 0], Q[:, 0], atol=1e-11)
        np.testing.assert_array_equal(found[:, 1], made.field("w", s=s)(Q))
        np.testing.assert_allclose(found[:, 2], 2, atol=1e-13)
    assert np.abs(made.field("w", s=3)(Q)).max() < 0.02 < 0.5 < np.abs(made.field("w", s=1)(Q)).max()
    with pytest.raises(PoreError) as error:
        porelang.compile("param h = 1mm in 0.5mm..4mm\nout v = blur(x, 2mm, cube(20), voxel=h)").field("v", h=3)
    assert error.value.diagnostics[0].code == "E156"


def test_a_ridge_has_a_direction_after_a_blur() -> None:
    """On the medial axis of a box its distance has a ridge, where the gradient jumps; after a blur it is smooth."""
    line = np.stack([np.linspace(-0.5, 0.5, 201), np.zeros(201), np.zeros(201)], axis=1)
    sharp = of("grad(box([8, 40, 40]))", line)
    soft = of("grad(blur(box([8, 40, 40]), 1.5mm, cube(20), smooth=true))", line)
    assert np.abs(np.diff(sharp[:, 0])).max() >= 1
    assert np.abs(np.diff(soft[:, 0])).max() < 0.01


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("blur(x, 1deg, cube(20))", "E062"),
        ("blur(x, x, cube(20))", "E063"),
        ("blur(x, 1mm, cube(20), voxel=x)", "E063"),
        ("blur(x, 1mm, cube(20), smooth=2)", "E060"),
        ("blur(x > 1, 1mm, cube(20))", "E060"),
        ("blur(x, 1mm, gyroid(5))", "E091"),
        ("blur(x, 1mm, cube(20), voxel=0.001mm)", "E096"),
        ("blur(1 / x, 1mm, cube(20), voxel=1mm)", "E097"),
        ("blur(x, 1mm)", "E043"),
    ],
)
def test_what_cannot_be_blurred_is_told(text: str, code: str) -> None:
    with pytest.raises(PoreError) as error:
        of(text)
    assert error.value.diagnostics[0].code == code
