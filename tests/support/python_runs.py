"""Runs through the Python interface, compared to the bit."""

from console.api.result import Run


def arrays(run: Run) -> dict[str, bytes]:
    """The shape, the type and the bytes of every array of a run."""
    own = {name: getattr(run, name) for name in ("time", "poses", "twists")}
    return {
        name: repr((values.shape, values.dtype)).encode() + values.tobytes()
        for name, values in (own | vars(run.links)).items()
    }


def of_machine(summary: dict[str, object]) -> dict[str, object]:
    """A summary without the quantities of the machine and the backend."""
    omitted = ("wall_s", "ticks_per_s", "real_time_factor", "backend", "model_free")
    return {name: value for name, value in summary.items() if name not in omitted}
