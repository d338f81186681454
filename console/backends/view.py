"""Views of a run with processes: an observer's session that lasts as long as the run."""

from collections.abc import Callable, Coroutine
from functools import partial

from rich.console import Console

from console.connect import index_source, observer
from console.dashboard import live, summary
from console.terminal import printing, progress
from console.terminal.formatting import length
from console.terminal.printing import is_screen
from fes.protocol import keys
from fes.protocol.report import Report
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from world.config.scenario import Scenario

RUN = keys.DEFAULT_RUN

View = Callable[[Endpoints], Coroutine[None, None, None]]
"""Shows a run to a person, as an observer with these endpoints, until the run is over."""


def on_screen(console: Console, dashboard: bool, scenario: Scenario) -> View | None:
    """A view in a terminal: the dashboard on `console`, or a bar of ticks on standard error; None without one."""
    if not dashboard:
        return partial(_show_progress, scenario.ticks) if is_screen(printing.console(stderr=True)) else None
    if not is_screen(console):
        return None
    return partial(_show_dashboard, live.Screen(console, summary.below(scenario), source=index_source.of(scenario)))


def of_reports(watch: Callable[[Report], None]) -> View:
    """A view that calls `watch` with every Report, in the thread of the event loop."""

    async def follow(endpoints: Endpoints) -> None:
        async with bus.opened(endpoints) as session:
            async for report in observer.reports(session, RUN, endpoints.timeout, live.IDLE):
                if report is not None:
                    watch(report)

    return follow


async def _show_dashboard(screen: live.Screen, endpoints: Endpoints) -> None:
    async with bus.opened(endpoints) as session:
        with screen:
            await live.watch(session, RUN, endpoints.timeout, screen)


async def _show_progress(ticks: int, endpoints: Endpoints) -> None:
    with progress.drawn("waiting for the robots", ticks) as bar:

        def show(report: Report) -> None:
            bar.name("running")
            bar(report.tick + 1)
            bar.note(f"largest error {length(report.separation_error_max)}")

        await of_reports(show)(endpoints)
