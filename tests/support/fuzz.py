"""Every decoder under mutated payloads, for a chosen time: python -m tests.support.fuzz --minutes 10 [--seed N].

With atheris installed, `--atheris` lets it choose the bytes by coverage; further arguments are libFuzzer's.
A failure is printed with its seed, decoder and payload, and the exit code is 1.
"""

import argparse
import importlib
import inspect
import sys
import time
from collections import Counter
from random import Random

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fes.protocol import channel_change, messages, report, wire, world_info
from tests.support.mutations import mutate
from tests.support.payloads import CODECS, assert_refused_or_a_message, refusal

SLOWEST = 2.0
"""Longest time to decode a payload of a mebibyte [s]; a loop over its value would exceed it."""


def corpus(count: int) -> dict[str, list[bytes]]:
    """Valid payloads of every kind."""
    payloads: dict[str, list[bytes]] = {name: [] for name in CODECS}

    @settings(max_examples=count, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
    @given(st.data())
    def collect(data: st.DataObject) -> None:
        for name, codec in CODECS.items():
            payloads[name].append(codec.encode(data.draw(codec.messages)))

    collect()
    return payloads


def attack(name: str, payload: bytes) -> str | None:
    """Reason why a payload is rejected, or None if it is a message; raises for a broken decoder."""
    begun = time.perf_counter()
    if len(payload) > wire.MAX_PAYLOAD // 16:  # long ones are only decoded, not compared field by field
        reason = refusal(name, payload)
    else:
        assert_refused_or_a_message(name, payload)
        reason = refusal(name, payload)
    assert time.perf_counter() - begun < SLOWEST
    return reason


def run(minutes: float, seed: int) -> int:
    """Mutate and decode until the time is over; returns an exit code."""
    random, seeds = Random(seed), corpus(200)
    everything = [payload for payloads in seeds.values() for payload in payloads]
    tried: Counter[str] = Counter()
    accepted: Counter[str] = Counter()
    rules: set[str] = set()
    end = time.monotonic() + 60.0 * minutes
    while time.monotonic() < end:
        for name, payloads in seeds.items():
            payload = mutate(random, random.choice(payloads), everything)
            try:
                reason = attack(name, payload)
            except BaseException:
                print(f"BROKEN: seed {seed}, {name}, payload {payload[:2000].hex()} ({len(payload)} bytes)")
                raise
            tried[name] += 1
            if reason is None:
                accepted[name] += 1
            else:
                rules.add(":".join(reason.split(":")[:2]))
    for name in seeds:
        print(f"{name:12} {tried[name]:9,} payloads, {accepted[name]:8,} of them messages")
    print(f"{tried.total():,} payloads, {len(rules)} different refusals, nothing broken; seed {seed}")
    return 0


def by_coverage(arguments: list[str]) -> None:
    """Run atheris: its first byte names the decoder."""
    atheris = importlib.import_module("atheris")

    names = list(CODECS)

    def one(data: bytes) -> None:
        if data:
            attack(names[data[0] % len(names)], data[1:])

    for module in (world_info, channel_change, messages, report, wire):
        for function in vars(module).values():
            if inspect.isfunction(function):
                atheris.instrument_func(function)
    atheris.Setup([sys.argv[0], *arguments], one)
    atheris.Fuzz()


def main() -> int:
    """Entry point of the command."""
    parser = argparse.ArgumentParser(prog="python -m tests.support.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--atheris", action="store_true")
    flags, rest = parser.parse_known_args()
    if flags.atheris:
        by_coverage([f"-max_total_time={round(60 * flags.minutes)}", *rest])
    return run(flags.minutes, flags.seed)


if __name__ == "__main__":
    sys.exit(main())
