"""Radios of robots over real UDP sockets and a relay: each beacon once, and nothing that the team did not send."""

import asyncio
import contextlib
import socket
import time

import pytest

from fes.errors import FesError, MessageError, TransportError
from fes.protocol import sealed
from fes.protocol.sealed import Sealed
from field.radio.replay_window import FORMER_START, REPEATED, SECOND_START, TAKEOVER
from field.radio.settings import RadioSettings
from field.radio.socket import SAME_ROBOT, Radio
from tests.support.ears import KEY, RUN, Ear, awaited, comes, radio
from tests.support.forwarding import forwarding
from tests.support.processes import PATIENCE

BURST = 300
"""More datagrams than arrive between two ticks of a large team."""


@awaited
async def test_beacons_reach_every_other_robot_in_order_with_their_time_of_arrival() -> None:
    ears = [Ear() for _ in range(3)]
    async with forwarding() as (relay, address):
        with contextlib.ExitStack() as stack:
            radios = [stack.enter_context(await radio(address, robot, ear)) for robot, ear in enumerate(ears)]
            await comes(lambda: len(relay.robots) == 3)  # by their first datagrams, before any beacon
            began = time.monotonic_ns()
            for number in range(20):
                for robot, each in enumerate(radios):
                    assert each.send(b"%d %d" % (robot, number))
            await comes(lambda: all(len(ear.heard) == 40 for ear in ears))
            for robot, (ear, each) in enumerate(zip(ears, radios, strict=True)):
                for peer in {0, 1, 2} - {robot}:
                    got = [beacon for beacon in ear.heard if beacon.robot == peer]
                    assert got == [Sealed(peer, radios[peer].boot, n + 1, b"%d %d" % (peer, n)) for n in range(20)]
                assert began <= ear.arrived[0] <= ear.arrived[-1] <= time.monotonic_ns()
                assert ear.arrived == sorted(ear.arrived)
                assert (each.counters.sent, each.counters.heard, each.counters.overflowed) == (21, 40, 0)
                assert not each.counters.refused


@awaited
async def test_a_datagram_that_the_team_did_not_send_is_refused_and_counted_by_its_rule() -> None:
    ear = Ear()
    async with forwarding() as (relay, address):
        with await radio(address, 0, ear) as mine, await radio(address, 1, Ear()) as peer:
            await comes(lambda: len(relay.robots) == 2)
            peer.send(b"true")
            await comes(lambda: len(ear.heard) == 1)
            true = relay.datagrams[-1]
            relay.inject(0, true)
            relay.inject(0, true[:-1] + bytes([true[-1] ^ 1]))
            relay.inject(0, sealed.seal(b"a guess", RUN, 1, peer.boot, 9, b"x"))
            relay.inject(0, sealed.seal(KEY, "other", 1, peer.boot, 9, b"x"))
            relay.inject(0, sealed.seal(KEY, RUN, 1, peer.boot ^ 1, 0, b"x"))
            relay.inject(0, sealed.seal(KEY, RUN, 0, mine.boot ^ 1, 0, b"x"))
            relay.inject(0, sealed.seal(KEY, RUN, 0, mine.boot, 99, b"x"))
            relay.inject(0, b"x")
            relay.inject(0, bytes(60_000))
            peer.send(b"last")
            await comes(lambda: len(ear.heard) == 2)
            assert [beacon.payload for beacon in ear.heard] == [b"true", b"last"]
            assert mine.counters.own == 1
            assert mine.counters.refused == {
                REPEATED: 1,
                sealed.FORGED: 2,
                sealed.OTHER_RUN: 1,
                SECOND_START: 1,
                SAME_ROBOT: 1,
                sealed.WRONG_LENGTH: 2,
            }


@awaited
async def test_a_restarted_robot_is_heard_again_and_its_former_beacons_are_not() -> None:
    ear = Ear()
    async with forwarding() as (relay, address):
        with await radio(address, 0, ear) as mine:
            with await radio(address, 1, Ear()) as first:
                await comes(lambda: len(relay.robots) == 2)
                first.send(b"former")
                await comes(lambda: len(ear.heard) == 1)
                former = relay.datagrams[-1]
            with await radio(address, 1, Ear()) as second:
                assert second.boot != first.boot

                def again() -> bool:
                    second.send(b"restarted")
                    return len(ear.heard) > 1

                await comes(again)
                assert ear.arrived[1] - ear.arrived[0] >= TAKEOVER
                relay.inject(0, former)
                await comes(lambda: mine.counters.refused[FORMER_START] == 1)
    assert {beacon.payload for beacon in ear.heard[1:]} == {b"restarted"}


@awaited
async def test_a_relay_that_starts_later_is_reached_by_the_next_beacons() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as reserved:
        reserved.bind(("127.0.0.1", 0))
        port = reserved.getsockname()[1]
    loop = asyncio.get_running_loop()
    with await radio(f"127.0.0.1:{port}", 0, Ear()) as mine:
        mine.send(b"nobody listens")
        heard = loop.create_future()

        class Late(asyncio.DatagramProtocol):
            def datagram_received(self, data: bytes, addr: object) -> None:
                if not heard.done():
                    heard.set_result(data)

        transport, _ = await loop.create_datagram_endpoint(Late, local_addr=("127.0.0.1", port))
        await comes(lambda: mine.send(b"now") and heard.done())
        assert sealed.opened(KEY, RUN, heard.result()).payload == b"now"
        transport.close()


@awaited
async def test_a_burst_that_arrived_between_two_ticks_is_read_whole() -> None:
    ear = Ear()
    async with forwarding() as (relay, address):
        with await radio(address, 0, ear) as mine:
            await comes(lambda: len(relay.robots) == 1)
            asyncio.get_running_loop().remove_reader(mine)
            for number in range(BURST):
                relay.inject(0, sealed.seal(KEY, RUN, 1, 5, number, b"x"))
            async with asyncio.timeout(PATIENCE):
                while len(ear.heard) < BURST:
                    mine.receive()
                    await asyncio.sleep(0.001)


@awaited
async def test_a_payload_that_is_too_long_is_an_error_of_its_sender() -> None:
    async with forwarding() as (_, address):
        with await radio(address, 0, Ear()) as mine, pytest.raises(MessageError, match="must have at most"):
            mine.send(bytes(1400))


@pytest.mark.parametrize("relay", ["127.0.0.1", "127.0.0.1:", ":7460", "127.0.0.1:0", "127.0.0.1:65536", "a:b"])
@awaited
async def test_a_relay_that_is_not_an_address_is_an_error_in_one_line(relay: str) -> None:
    with pytest.raises(FesError, match="a relay must be host:port, got: "):
        await radio(relay, 0, Ear())


@awaited
async def test_a_group_that_cannot_be_joined_is_an_error_in_one_line() -> None:
    settings = RadioSettings(group="127.0.0.1", port=0)  # not a multicast group
    with pytest.raises(TransportError, match=r"radio group 127\.0\.0\.1:0: "):
        await Radio.opened(settings, RUN, 0, Ear())
    with pytest.raises(TransportError, match=r"on no-such: "):
        await Radio.opened(RadioSettings(interface="no-such"), RUN, 0, Ear())


@awaited
async def test_datagrams_that_the_system_drops_while_a_robot_does_not_read_are_told_from_losses() -> None:
    ear, sent = Ear(), 5000
    async with forwarding() as (relay, address):
        with await radio(address, 0, ear) as mine:
            await comes(lambda: len(relay.robots) == 1)
            for number in range(sent):  # the loop, and so the robot, waits meanwhile
                relay.inject(0, sealed.seal(KEY, RUN, 1, 5, number, bytes(1000)))
            await comes(lambda: bool(ear.heard) and ear.heard[-1].sequence > 100)
            before = 0
            while before < len(ear.heard):
                before = len(ear.heard)
                await asyncio.sleep(0)
            relay.inject(0, sealed.seal(KEY, RUN, 1, 5, sent, b"last"))
            await comes(lambda: ear.heard[-1].payload == b"last")
            assert mine.counters.overflowed > 0
            assert len(ear.heard) + mine.counters.overflowed == sent + 1
