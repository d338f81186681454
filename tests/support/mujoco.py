"""Tests with bodies in MuJoCo: skipped, and loudly so, where it is not installed."""

import importlib.util

import pytest

from fes.system import distribution

needs_mujoco = pytest.mark.skipif(
    importlib.util.find_spec("mujoco") is None,
    reason=f"MuJoCo is not installed; these tests run after {distribution.install('mujoco')}",
)
