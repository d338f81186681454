"""The page of a secured run: an observer has no controls, and the world refuses its request; an operator has them."""

import asyncio
from pathlib import Path

import pytest

from console.connect import channel_request
from console.keys import certificates
from fes.errors import Unavailable
from fes.protocol.channel_change import ParameterChange
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.browser import Browser, browser, needs_browser, page
from tests.support.processes import PATIENCE, until
from tests.support.stage import ROLES, RUN, Stage

pytestmark = [needs_browser, pytest.mark.slow]

CHANGE = ParameterChange("channel.reference_snr", 5e6)


def request(endpoint: str, keyed: Path, role: str) -> float:
    """Request a change with the certificate of a role; returns r* [m]."""

    async def main() -> float:
        own = team_keys.security(keyed, role)
        async with bus.opened(Endpoints("client", (endpoint,), timeout=PATIENCE, security=own)) as opened:
            return (await channel_request.send(opened, RUN, CHANGE, 2.0)).optimal_separation

    return asyncio.run(main())


def has_controls(shown: Browser) -> bool:
    return bool(shown.run("return model('set') !== null || find(document, 'button.bk-btn-primary') !== null"))


def test_an_observer_has_no_controls_and_an_operator_changes_the_channel(tmp_path: Path) -> None:
    keyed = team_keys.directory(tmp_path / "keys", certificates.create(1.0), ROLES)
    staged = Stage(tmp_path, keyed, ["--duration", "100000"])
    try:
        for robot in range(2):
            staged.agent(robot)
        words = ["view", "-e", staged.endpoint, "--keys", str(keyed)]
        with browser(tmp_path / "profile") as window:
            with page(tmp_path, *words) as (address, _):
                window.open(address)
                until(lambda: window.tick() > 0)
                assert not has_controls(window)
                assert window.errors() == []
            with pytest.raises(Unavailable, match=f"no world of run '{RUN}' answers"):
                request(staged.endpoint, keyed, "observer")
            until(lambda: "dropped observer's query" in staged.log())
            with page(tmp_path, *words, "--operator") as (address, _):
                window.open(address)
                until(lambda: "r* <b>68.11 m</b>" in window.text("header"))
                window.element("input[type=text]").send_keys("5e6")
                window.element("button.bk-btn-primary").click()
                until(lambda: "r* <b>65.52 m</b>" in window.text("header"))
                assert window.errors() == []
    finally:
        staged.end()
