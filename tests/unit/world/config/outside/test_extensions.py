"""The extensions of a scenario that other processes need."""

import sys
from types import ModuleType

import pytest

from fes.errors import FesError
from fes.extension import registry
from tests.support.example_metric import Count
from world.config.outside import extensions
from world.config.scenario import Scenario, parse

LINE = "metric '__main__:Count': no other process can import it; put the class into a file"


def with_metric(use: str) -> Scenario:
    return parse({"schema": 1, "robots": {"count": 2}, "metric": [{"use": use}]}, "here")


def test_a_class_of_the_program_itself_is_refused_where_other_processes_need_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = ModuleType("__main__")
    program.Count = Count  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "__main__", program)
    try:
        for module in ("__main__", "tests.support.example_metric"):
            registry.use(module)
        assert registry.used()[-1] == "tests.support.example_metric"
        assert "__main__" not in registry.used()
        extensions.check_importable(with_metric("tests.support.example_metric:Count"))
        with pytest.raises(FesError) as raised:
            extensions.check_importable(with_metric("__main__:Count"))
        assert str(raised.value) == LINE
    finally:
        registry.withdraw("__main__")
