"""The command fes fit, from its arguments to its lines."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from console.analysis import figures
from console.fit import estimate, measurements, picture, report
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError, reason
from fes.system import strict_json


class Model(StrEnum):
    """Channels that can be fitted."""

    RAYLEIGH = "rayleigh"
    LOGISTIC = "logistic"
    TABLE = "table"


def fit(
    file: Annotated[
        Path, typer.Argument(help="Comma-separated file: columns separation [m], and decoded (0 or 1) or rssi [dBm].")
    ],
    model: Annotated[Model, typer.Option(help="Channel to fit.")] = Model.RAYLEIGH,
    noise_floor: Annotated[
        float | None, typer.Option(min=-300, max=100, help="Noise at the receivers [dBm], for a column rssi.")
    ] = None,
    sensitivity: Annotated[
        float | None, typer.Option(min=-300, max=100, help="Least power that decodes [dBm], for a column rssi.")
    ] = None,
    spectral_efficiency: Annotated[
        float, typer.Option(min=1e-3, max=100, help="Spectral efficiency of a rayleigh channel [bit/s/Hz].")
    ] = 2.0,
    plot: Annotated[
        Path | None, typer.Option(metavar="PICTURE", help="Draw measurements and fit, as PNG and SVG.")
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the fit as JSON, and nothing else.")] = False,
) -> int:
    """Fit a channel to measured packets or received power, and print it as a table of a scenario."""
    least_power = measurements.threshold(noise_floor, sensitivity, spectral_efficiency)
    if plot is not None:
        figures.require()
    with progress.shown("reading") as bar:
        measured = measurements.read(file, least_power)
        bar.name("fitting")
        try:
            fitted = estimate.fit(measured, model.value, spectral_efficiency)
        except FesError as error:
            raise FesError(f"{file}: {error}") from None
        drawn: list[Path] = []
        if plot is not None:
            bar.name("drawing")
            try:
                drawn = figures.save(picture.figure_of(fitted, measured), plot)
            except OSError as error:
                raise FesError(f"cannot write the picture: {reason(error)}") from None
    if json_:
        print(strict_json.dumps(report.table(fitted, measured)))
        return process.SUCCESS
    for line in [*report.toml(fitted, measured, file.name), *(f"# picture: {path}" for path in drawn)]:
        printing.line(line)
    return process.SUCCESS
