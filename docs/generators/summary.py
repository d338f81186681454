"""The page of the summary: every quantity, with its kind, unit and meaning."""

from docs.generators.markdown import code, table
from world.config import expectations
from world.config.expectations import Shape

TITLE = "Summary"
INTRODUCTION = """`summary.json` in the run directory, and `fes run --json` on standard output, hold one JSON
object. Its keys are stable: scripts may rely on them. A quantity that does not exist, or is not finite, is null. An
`[[expect]]` table of a [scenario](scenario.md#expect) names a quantity by its dotted path, such as
`time_to.estimate_1m` or `tracking.0.rmse`."""

MEANINGS = {
    "scenario": ("", "Name of the scenario."),
    "seed": ("", "Seed of the run."),
    "backend": ("", "`processes` or `inprocess`."),
    "clock": ("", "`lockstep` or `live`."),
    "robots": ("1", "Number of robots."),
    "ticks": ("1", "Ticks that were run; after an interruption fewer than the scenario has."),
    "dt": ("s", "Tick length."),
    "simulated_s": ("s", "Simulated time."),
    "wall_s": ("s", "Wall-clock time."),
    "ticks_per_s": ("1/s", "Ticks per second of wall clock."),
    "real_time_factor": ("1", "Simulated time divided by wall-clock time."),
    "optimal_separation": ("m", "r\\*: the maximum of the index (16) with the channel's formula at the end."),
    "separation_error_max": ("m", "Largest error of a link's length at the end."),
    "separation_error_rms": ("m", "Root mean square of the same errors."),
    "disagreement": ("m", "Sum over the links of the difference between the estimates of both ends, at the end."),
    "estimate_error_max": ("m", "Largest error of an estimate at the end."),
    "estimate_error_rms": ("m", "Root mean square of the same errors."),
    "disk_connected_always": ("", "True if the graph of the robots in range was connected at every tick."),
    "links_connected_always": ("", "True if the graph of links was connected at every tick."),
    "algebraic_connectivity": ("1", "λ₂ of the graph of links at the end; 0 if it is not connected."),
    "beacons_sent": ("1", "Beacons sent, counted once per receiver in range."),
    "beacons_decoded": ("1", "Beacons of these that decoded."),
    "links_gap_longest": ("s", "Longest time in which the links did not connect the robots that took part."),
    "links_lost_at": ("s", "Time since which no robot has had a link; 0 if none ever had one, null if one exists."),
    "unscheduled_absences": ("1", "Robot-ticks in which a robot took no part although the scenario had it present."),
    "digest": ("", "SHA-256 of the run, described below."),
    "time_to.disagreement_1m": ("s", "First time from which the disagreement stays below 1 m."),
    "time_to.estimate_1m": ("s", "First time from which all estimates stay within 1 m of r\\*."),
    "time_to.estimate_0_1m": ("s", "The same for 0.1 m."),
    "time_to.separation_1m": ("s", "First time from which all links stay within 1 m of r\\*."),
    "time_to.separation_0_1m": ("s", "The same for 0.1 m."),
    "tracking[].at": ("s", "Start of a segment: the start of the run, or a change of the channel."),
    "tracking[].optimal_separation": ("m", "r\\* in the segment."),
    "tracking[].time_to_1m": ("s", "Time after `at` from which the mean estimate stays within 1 m of r\\*."),
    "tracking[].bias": ("m", "Mean error of the mean estimate, once the segment has settled."),
    "tracking[].rmse": ("m", "Root mean square of the same error."),
    "tracking[].separation_rmse": ("m", "Root mean square error of the separations, averaged over a dither period."),
    "tracking[].disagreement_max": ("m", "Largest disagreement in the segment."),
    "tracking[].index": ("1", "Mean performance index J of the links."),
    "deadlines.due[]": ("1", "Live clock only, per robot: deadlines."),
    "deadlines.missed[]": ("1", "Deadlines that the robot missed."),
    "deadlines.stopped[]": ("1", "Ticks at which the robot stood still for lack of a recent command."),
    "deadlines.late[]": ("1", "Commands that arrived after their deadline."),
    "deadlines.missed_share": ("1", "Missed deadlines of all robots, divided by all deadlines."),
    "deadlines.slipped_s": ("s", "Sum of the times by which the world's clock slipped."),
    "arithmetic.fingerprint": ("", "Hash of the results of elementary functions, sums and matrix products."),
    "arithmetic.numpy": ("", "Version of numpy."),
    "arithmetic.core": ("", "Implementation that computes the run."),
    "edges[]": ("m", "Per link at the end: lower id, higher id, separation, both estimates in this order."),
    "radio[]": ("1", "Per contact: receiver, sender, beacons sent, decoded, mean true outage, longest gap."),
}  # fmt: skip
"""Unit and meaning of every quantity, by its path; `[]` stands for the place in a list."""

NOTES = """`expectations` has one entry per `[[expect]]` table: `of`, `expected` (the rule in words), `seen` and
`holds`.

A level of `time_to` counts as reached if it holds for 10 s, or to the end if the run ends sooner. It is null if it
is never reached. r\\* is computed from the channel's formula alone, without shadowing, bursts, jammers and
partitions. Separations of a formation with a physical dither are averaged over a period of the dither.

**The digest** is the SHA-256 over all ticks in order. Each tick contributes its number as int64. Then each robot,
in id order, contributes x, y, heading, linear and angular as float64: the pose at the tick, and the twist held
after it. All numbers are little-endian. On one machine with the same library versions, the digest is the same for
the same scenario and seed: in every backend and placement, in any start order, under any load."""


def page() -> list[str]:
    """The lines of the page, without its title."""
    rows = [[code(path), kind, *MEANINGS[path]] for path, kind in quantities()]
    return [*table(["quantity", "kind", "unit", "meaning"], rows), NOTES, ""]


def quantities() -> list[tuple[str, str]]:
    """Path and kind of every quantity of a summary."""
    found: list[tuple[str, str]] = []
    _walk("", expectations.SUMMARY, found)
    return sorted(found, key=lambda quantity: list(MEANINGS).index(quantity[0]))


def _walk(path: str, shape: Shape, found: list[tuple[str, str]]) -> None:
    if isinstance(shape, dict):
        for key, below in shape.items():
            _walk(f"{path}.{key}" if path else key, below, found)
    elif isinstance(shape, list):
        _walk(f"{path}[]", shape[0], found)
    else:
        found.append((path, f"row of {len(shape)}" if isinstance(shape, tuple) else shape.removeprefix("a ")))
