"""The process fes-tabletop: bodies in real time, their drivers on the bus, and the relay of the radio."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small

import argparse
import asyncio
import contextlib
import logging
import time
from pathlib import Path
from typing import TextIO

from fes import process
from fes.arrays.types import Floats
from fes.errors import FesError, reason
from fes.model import counts
from fes.protocol import sealed
from fes.system import output
from fes.transport import bus
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints
from world.config import builtin
from world.config.hardware.tabletop import TabletopConfig
from world.config.scenario import Scenario, load
from world.tabletop import flags, truth_file
from world.tabletop.bodies import team
from world.tabletop.drivers import Drivers
from world.tabletop.pacing import Pacing
from world.tabletop.radio import radio_socket
from world.tabletop.radio.radio_socket import Place
from world.tabletop.radio.reachability import Reachability
from world.tabletop.radio.relay import Relay

REFRESH = 0.02
"""Time between two measurements of the separations for the relay [s]."""

_logger = logging.getLogger("tabletop")


class Tabletop:
    """A team of bodies in real time."""

    def __init__(self, scenario: Scenario, config: TabletopConfig) -> None:
        self.config = config
        """The table [tabletop] of the scenario."""
        self._bodies = team.create(scenario, config)
        self._reachability = Reachability(scenario)
        self.relay: Relay[Place] = Relay(scenario.robots.number, self._reachability.measure(self._full_size(), 0.0))
        self.drivers: Drivers | None = None
        """The drivers; bodies without them stand still."""
        self.truth: TextIO | None = None
        """The file that gets the truth."""
        self.lost = 0.0
        """Time for which the bodies have stood still, as this process was too late [s]."""
        self._period = config.steps_per_cycle * config.physics_step
        self._cycles = 0

    @property
    def time(self) -> float:
        """Time of the bodies [s]."""
        return self._cycles * self._period

    async def main_loop(self) -> None:
        """Move the bodies in real time, until this task is cancelled."""
        pacing = Pacing(self._period, time.monotonic())
        while True:
            for _ in range(pacing.due(time.monotonic())):
                self.cycle()
            if pacing.lost and not self.lost:
                _logger.warning("too late for real time: the bodies stood still for %.2f s", pacing.lost)
            self.lost = pacing.lost
            await asyncio.sleep(max(0.0, pacing.next - time.monotonic()))

    def cycle(self) -> None:
        """One cycle of bodies, drivers, relay and truth."""
        now = time.monotonic()
        if self.drivers is not None:
            self.drivers.obey(self._bodies, now)
        self._bodies.step(self._period)
        self._cycles += 1
        if self.drivers is not None:
            self.drivers.report(self._cycles, self._bodies.poses(), self._bodies.twists(), time.time_ns())
        if self._is_due(REFRESH):
            self.relay.reach = self._reachability.measure(self._full_size(), self.time)
        if self.truth is not None and self._is_due(truth_file.PERIOD):
            twists = self._bodies.twists()
            self.truth.write(truth_file.line(self.time, now, self._full_size(), twists, self.relay) + "\n")

    def _is_due(self, period: float) -> bool:
        """True at the cycles at which a `period` [s] ends."""
        return self._cycles % counts.ticks_of(period, self._period) == 0

    def _full_size(self) -> Floats:
        return team.at_full_size(self._bodies.poses(), self.config.scale)


async def serve(scenario: Scenario, listen: tuple[str, ...], radio: Place, truth: Path | None) -> int:
    """A table from start to exit; returns the exit code."""
    config = scenario.tabletop or TabletopConfig()
    if scenario.event:
        _logger.warning("fes-tabletop ignores the %d events of the scenario", len(scenario.event))
    table = Tabletop(scenario, config)
    async with bus.opened(Endpoints("router", (), listen)) as opened:
        with contextlib.ExitStack() as stack:
            sender = sealed.sender
            relay = stack.enter_context(radio_socket.opened(radio, table.relay, sender, scenario.run.seed))
            if truth is not None:
                table.truth = stack.enter_context(truth_file.create(truth))
            table.drivers = Drivers(opened, config, scenario.robots.number)
            body = f"{scenario.robots.number} robots ({config.body}, 1:{config.scale:g})"
            _logger.info("ready: %s, router at %s, radio at %s", body, ", ".join(listen), relay.place)
            try:
                await table.main_loop()
            finally:
                sent, forwarded = int(table.relay.sent.sum()), int(table.relay.forwarded.sum())
                _logger.info(
                    "%.1f s, and %.1f s lost: %d of %d datagrams forwarded", table.time, table.lost, forwarded, sent
                )
                obeyed, ignored = table.drivers.obeyed, table.drivers.ignored
                _logger.info("%d commands obeyed, %d samples ignored", obeyed, ignored)
    return process.SUCCESS


def _read(given: argparse.Namespace) -> Scenario:
    """The scenario that the flags describe; raises FesError."""
    return load(builtin.resolve(Path(given.scenario)), flags.overrides(given))


def main() -> None:
    """Run fes-tabletop."""
    output.configure()
    command_line = flags.parser()
    given = command_line.parse_args()
    try:
        scenario = _read(given)
    except OSError as error:
        command_line.error(reason(error))
    except FesError as error:
        command_line.error(str(error))
    listen = tuple(given.listen) or (DEFAULT_ENDPOINT,)
    process.run(
        "fes-tabletop",
        lambda: serve(scenario, listen, given.radio, given.truth),
        exit_with_stdin=given.exit_with_stdin,
    )


if __name__ == "__main__":
    main()
