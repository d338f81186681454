"""Operators of real robots, over real Zenoh sessions: permit, start and stop."""

import asyncio

import pytest

from console.team import gates, permit, status
from fes.errors import Unavailable
from fes.protocol.robot_control import RUNNING, STOPPED
from tests.support.fake_robots import FakeGate
from tests.support.processes import PATIENCE
from tests.support.robot_sessions import gated, run, until
from tests.support.session import RUN, client, router


def test_started_robots_run_while_the_permit_is_held_and_are_stopped_when_it_ends() -> None:
    async def main() -> None:
        async with gated([0, 1, 4]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            robots = await gates.present(operator, RUN)
            assert robots == [0, 1, 4]
            held = asyncio.create_task(permit.start_and_hold(operator, RUN, robots, lines.append))
            await until(lambda: all(fake.mode == RUNNING for fake in fakes.values()))
            await until(lambda: all(f"robot {robot}: running" in lines for robot in robots))
            held.cancel()
            assert await held
            assert [fake.mode for fake in fakes.values()] == [STOPPED] * 3
            assert [fake.asked for fake in fakes.values()] == [["start", "stop"]] * 3
            assert lines[:2] == ["started: 0-1, 4", "the permit is renewed until Ctrl-C, which stops the robots"]
            assert lines[-1] == "stopped: 0-1, 4"
            count = len(fakes[0].permits)
            await permit.stop(operator, RUN, robots, lines.append)  # a round trip, in which no Permit arrives
            assert len(fakes[0].permits) == count

    run(main)


def test_robots_are_stopped_even_if_the_operator_leaves_before_they_have_started() -> None:
    async def main() -> None:
        async with gated([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            held = asyncio.create_task(permit.start_and_hold(operator, RUN, [0], lines.append))
            await until(lambda: bool(fakes[0].permits))
            held.cancel()
            assert not await held  # it was never started
            assert fakes[0].asked == ["stop"]
            assert lines == ["stopped: 0"]

    run(main)


def test_a_robot_without_a_permit_does_not_start_and_the_reason_is_shown() -> None:
    async def main() -> None:
        async with gated([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            assert not await permit.start(operator, RUN, [0, 1], lines.append)
            assert lines == [
                "robot 0 did not start: stopped, no permit",
                "robot 1 did not start: its gate does not answer",
            ]
            assert fakes[0].asked == ["start"]  # a start is never repeated

    run(main)


def test_a_stop_is_repeated_until_a_gate_confirms_it() -> None:
    async def main() -> None:
        async with router() as (opened, endpoint), client(endpoint) as operator:
            fake, lines = FakeGate(opened, RUN, 3, deaf_to_stops=2), list[str]()
            assert await permit.stop(operator, RUN, [3], lines.append, PATIENCE)
            assert lines == ["stopped: 3"]
            assert fake.asked == ["stop"] * 3

    run(main)


def test_a_robot_that_does_not_confirm_its_stop_is_named_and_the_others_are_stopped() -> None:
    async def main() -> None:
        async with gated([0, 2]) as (opened, endpoint, fakes), client(endpoint) as operator:
            FakeGate(opened, RUN, 1, deaf_to_stops=1000)
            lines: list[str] = []
            assert not await permit.stop(operator, RUN, [0, 1, 2, 3], lines.append, 0.5)
            assert lines == [
                "stopped: 0, 2",
                "robot 1 has NOT confirmed its stop: its gate does not answer",
                "robot 3 has NOT confirmed its stop: its gate does not answer",
            ]
            assert [fake.asked for fake in fakes.values()] == [["stop"], ["stop"]]

    run(main)


def test_permits_of_one_operator_rise_and_end_when_their_time_is_over() -> None:
    async def main() -> None:
        async with gated([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            await permit.publish(operator, RUN, 7 * permit.PERIOD)
            await permit.stop(operator, RUN, [0], lambda line: None)  # what was published before has arrived
            sequences = [sent.sequence for _, sent in fakes[0].permits]
            assert sequences == sorted(set(sequences))
            assert max(sequences) <= 7
            assert len({sent.operator for _, sent in fakes[0].permits}) == 1

    run(main)


def test_a_gate_lapses_after_the_permit_and_a_new_permit_does_not_start_it() -> None:
    async def main() -> None:
        async with gated([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            async with permit.held(operator, RUN):
                assert await permit.start(operator, RUN, [0], lambda line: None)
            await until(lambda: fakes[0].state.mode == STOPPED)
            async with permit.held(operator, RUN):
                [state] = await status.collect(operator, RUN, [0])
                assert gates.words(state.gate) == "stopped, the permit lapsed"

    run(main)


def test_a_stop_of_a_second_operator_wins_while_the_first_holds_the_permit() -> None:
    async def main() -> None:
        async with gated([0, 1]) as (_, endpoint, fakes), client(endpoint) as first, client(endpoint) as second:
            lines: list[str] = []
            held = asyncio.create_task(permit.start_and_hold(first, RUN, [0, 1], lines.append))
            await until(lambda: all(f"robot {robot}: running" in lines for robot in (0, 1)))
            assert await permit.stop(second, RUN, [1], lambda line: None)
            await until(lambda: "robot 1: stopped, stopped by the operator" in lines)
            assert fakes[0].mode == RUNNING
            held.cancel()
            assert await held

    run(main)


def test_permits_of_two_operators_differ_in_their_number() -> None:
    async def main() -> None:
        async with (
            gated([0]) as (_, endpoint, fakes),
            client(endpoint) as first,
            client(endpoint) as second,
            permit.held(first, RUN),
            permit.held(second, RUN),
        ):
            await until(lambda: len({sent.operator for _, sent in fakes[0].permits}) == 2)

    run(main)


def test_no_gate_at_all_is_an_error_in_one_line() -> None:
    async def main() -> None:
        async with router() as (_, endpoint), client(endpoint) as operator:
            with pytest.raises(Unavailable, match=f"no gate of run '{RUN}' is alive"):
                await gates.present(operator, RUN)

    run(main)
