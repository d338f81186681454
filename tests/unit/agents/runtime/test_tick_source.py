"""The shell of the tick machines: what it reads from the inbox, sends again, drops, and tells of the world."""

import asyncio
import logging
from collections.abc import Callable

import numpy as np
import pytest

from agents.runtime.tick_source import TickSource
from agents.runtime.world_liveliness import WorldLiveliness
from fes.errors import Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Observation
from fes.transport.drop_log import DropLog
from fes.transport.inbox import ThreadInbox

NOTHING = np.zeros(0, dtype=np.int64)
ODD = "Observation: is not for this tick"


class TickPayloads:
    """An outbox that stores the last two ticks, and notes what it sends again."""

    def __init__(self) -> None:
        self.last = -1
        self.repeated: list[int] = []

    def has(self, tick: int) -> bool:
        return self.last - 1 <= tick <= self.last

    def resend(self, tick: int, robot: int) -> None:
        self.repeated.append(tick)


Sense = Callable[..., None]
Scene = Callable[[int, Sense, WorldLiveliness], None]
"""The observations that arrive while a tick is being answered; the last of them ends the run."""


def observation(tick: int, robot: int, since: int = 0, over: bool = False) -> tuple[str, bytes]:
    """The key and the payload of an observation."""
    sensed = Observation(tick, robot, (0.0, 0.0, 0.0), NOTHING, NOTHING.astype(np.uint8), over, since)
    return keys.observation("test", robot), messages.encode_observation(sensed)


def play(scene: Scene, live: bool = False) -> tuple[list[int], TickPayloads, DropLog]:
    """The ticks that were answered, what was repeated, and what was odd, while tick 0 and then a scene come."""
    outbox, drops = TickPayloads(), DropLog(logging.getLogger("test"))
    answered: list[int] = []

    async def main() -> None:
        inbox = ThreadInbox()
        ticks, world = TickSource("test", (3,), inbox, outbox, drops), WorldLiveliness("the world", inbox)  # type: ignore[arg-type]

        def sense(tick: int, since: int = 0, over: bool = False) -> None:
            inbox.put(*observation(tick, 3, since, over))

        sense(0)
        for [received] in ticks.live(world) if live else ticks.lockstep(world):
            assert received.tick == ticks.tick
            answered.append(received.tick)
            outbox.last = received.tick
            scene(received.tick, sense, world)

    asyncio.run(main())
    return answered, outbox, drops


def test_an_early_tick_is_rejected_and_does_not_replace_the_next_one() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        for early in (2, 10**6):
            sense(tick + early)
        sense(tick + 1, over=tick == 3)

    answered, outbox, drops = play(scene)
    assert answered == [0, 1, 2, 3]
    assert not outbox.repeated
    assert drops.counts == {ODD: 8}


def test_ticks_that_arrive_together_are_all_answered_in_their_order() -> None:
    """The world does not wait for a robot that is dead by schedule, so such a robot can be several ticks late."""

    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        if tick == 0:
            for later in (1, 2, 3):
                sense(later)
        if tick == 3:
            sense(4, over=True)

    answered, _, drops = play(scene)
    assert answered == [0, 1, 2, 3]
    assert not drops.counts


def test_observations_of_two_ticks_that_arrive_together_are_read_in_their_order() -> None:
    """Two robots of one process: a tick is complete when the first observation of the next one has arrived."""
    drops, stepped = DropLog(logging.getLogger("test")), list[list[tuple[int, int]]]()

    async def main() -> None:
        inbox = ThreadInbox()
        world = WorldLiveliness("the world", inbox)
        ticks = TickSource("test", (0, 1), inbox, TickPayloads(), drops).lockstep(world)  # type: ignore[arg-type]
        for together in ([(0, 0), (0, 1), (1, 0)], [(1, 1), (2, 0)], [(2, 1)]):
            for tick, robot in together:
                inbox.put(*observation(tick, robot))
            inbox.fail(Unavailable("the test is over"))  # once all that has arrived is read
            stepped.append([(received.tick, received.robot) for received in next(ticks)])

    asyncio.run(main())
    assert stepped == [[(tick, 0), (tick, 1)] for tick in range(3)]
    assert not drops.counts


def test_a_repeated_tick_is_answered_again_and_an_older_one_is_rejected() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        for late in (0, 1, 2):
            sense(max(0, tick - late))
        sense(tick + 1, over=tick == 2)

    answered, outbox, drops = play(scene)
    assert answered == [0, 1, 2]
    assert outbox.repeated == [0, 0, 0, 1, 2]
    assert drops.counts == {ODD: 4}


def test_a_resumed_world_is_also_answered_one_tick_back_and_an_agent_that_cannot_do_so_ends() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        if tick == 2:
            world.is_new = True
            sense(1)
        sense(tick + 1, over=tick == 3)

    assert play(scene)[1].repeated == [1]

    def too_old(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        if tick < 3:
            sense(tick + 1)
            return
        world.is_new = True
        sense(1)
        sense(1)

    with pytest.raises(Unavailable, match=r"^the world is back at tick 1, but tick 3 was answered already$"):
        play(too_old)


def test_a_restarted_world_is_new_only_until_the_next_tick_is_stepped() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        if tick == 2:
            world.is_new = True
        else:
            assert not world.is_new
        if tick >= 2:
            sense(tick - 1)
        sense(tick + 1, over=tick == 3)

    answered, outbox, drops = play(scene)
    assert answered == [0, 1, 2, 3]
    assert outbox.repeated == [1]
    assert drops.counts == {ODD: 1}


def test_with_a_live_clock_an_agent_goes_back_once_with_a_restarted_world() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        if tick == 0:
            sense(7)
        elif tick == 7:
            world.is_new = True
            sense(5)
        elif tick == 5:
            assert not world.is_new
            sense(6, over=True)

    assert play(scene, live=True)[0] == [0, 7, 5]


def test_an_agent_that_was_absent_resumes_at_the_tick_of_its_rejoining() -> None:
    def scene(tick: int, sense: Sense, world: WorldLiveliness) -> None:
        sense(900 if tick == 0 else 901, since=900, over=tick > 0)

    answered, _, drops = play(scene)
    assert answered == [0, 900]
    assert not drops.counts
