"""A fit as TOML, with confidence intervals as comments, and as JSON."""

import shlex
from typing import Any

from console.fit.estimate import Fit
from console.fit.measurements import Packets, Powers
from fes.system import strict_json
from fes.system.output import printable

UNITS = {
    "reference_snr": "1",
    "reference_distance": "m",
    "path_loss_exponent": "1",
    "spectral_efficiency": "bit/s/Hz",
    "logistic_midpoint": "m",
    "logistic_width": "m",
}
CHOSEN = {
    "reference_distance": "chosen: geometric mean of the separations",
    "spectral_efficiency": "chosen",
}
METHOD = "maximum likelihood; 95 % intervals from the observed Fisher information"
METHOD_OF_SHARES = "shares of decoded packets; 95 % intervals by Wilson"


def toml(fit: Fit, measured: Packets | Powers, name: str) -> list[str]:
    """Lines of TOML: the table [channel], which a scenario accepts."""
    settings = fit.settings
    lines = [f"# {text}" for text in (*_of_measurements(measured, printable(name)), _method(fit))]
    if fit.spread is not None:
        lines.append(f"# deviation of the power / mean = {fit.spread:.2f}; Rayleigh fading has 1")
    lines += ["[channel]", f'model = "{settings["model"]}"']
    if "rows" in settings:
        lines += ["rows = [", *(_row(fit, number) for number in range(len(settings["rows"]))), "]"]
    fields = {name: repr(value) for name, value in settings.items() if name in UNITS}
    width = max((len(f"{name} = {text}") for name, text in fields.items()), default=0)
    for field, text in fields.items():
        known = f"95 %: {_between(fit.intervals[field])}" if field in fit.intervals else CHOSEN[field]
        lines.append(f"{f'{field} = {text}':<{width}}  # {UNITS[field]}; {known}")
    known = "" if fit.optimal_interval is None else f", 95 %: {_between(fit.optimal_interval)} m"
    words = [shlex.quote(f"channel.{name}={strict_json.dumps(value)}") for name, value in settings.items()]
    return [
        *lines,
        f"# r* = {fit.optimal:.2f} m for the default objective{known}",
        f"# as flags of fes run: {' '.join(f'--set {word}' for word in words)}",
    ]


def table(fit: Fit, measured: Packets | Powers) -> dict[str, Any]:
    """The fit as a table of JSON."""
    counts: dict[str, Any] = {"rows": len(measured.separation)}
    if isinstance(measured, Packets):
        counts |= {"decoded": int(measured.decoded.sum())}
    else:
        counts |= {"threshold": measured.threshold, "are_decoded": measured.are_decoded, "spread": fit.spread}
    return {
        **counts,
        "channel": fit.settings,
        "intervals": fit.intervals,
        "method": _method(fit),
        "log_likelihood": fit.log_likelihood,
        "optimal_separation": fit.optimal,
        "optimal_separation_interval": fit.optimal_interval,
    }


def _of_measurements(measured: Packets | Powers, name: str) -> list[str]:
    count = len(measured.separation)
    span = f"over {measured.separation.min():g} to {measured.separation.max():g} m"
    if isinstance(measured, Packets):
        return [f"{name}: {count} packets {span}, {int(measured.decoded.sum())} of them decoded"]
    below = int((measured.rssi < measured.threshold).sum())
    meaning = "so it has lost packets too" if below else "so it has decoded packets only"
    return [
        f"{name}: {count} received powers {span}",
        f"least power that decodes: {measured.threshold:g} dBm; {below} are below, {meaning}",
    ]


def _method(fit: Fit) -> str:
    return METHOD_OF_SHARES if "rows" in fit.settings else METHOD


def _row(fit: Fit, number: int) -> str:
    separation, share = fit.settings["rows"][number]
    return f"  [{separation!r}, {share!r}],  # m, 1; 95 %: {_between(fit.intervals[str(number)])}"


def _between(interval: tuple[float, float]) -> str:
    return " to ".join(f"{end:.4g}" for end in interval)
