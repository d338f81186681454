"""Tests with bodies in MuJoCo: skipped, and loudly so, where it is not installed."""

import importlib.util

import pytest

needs_mujoco = pytest.mark.skipif(
    importlib.util.find_spec("mujoco") is None,
    reason="MuJoCo is not installed: pip install -e '.[mujoco]' has these tests run",
)
