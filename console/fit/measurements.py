"""The file of measurements: packets that decoded or not, or received power, each at a separation."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Floats
from fes.errors import FesError, reason
from fes.system import files, number_columns
from fes.system.number_columns import Column

LARGEST = 1 << 28
"""Largest file that is read [bytes]."""

_SEPARATION = Column("separation", 1e-3, 1e6)
_DECODED = Column("decoded", 0, 1, is_whole=True)
_RSSI = Column("rssi", -300, 100)


class Packets(NamedTuple):
    """Packets, each sent over a separation."""

    separation: Floats
    """[k] [m]"""
    decoded: Bools
    """True for a packet that decoded [k]."""


class Powers(NamedTuple):
    """Received power, each over a separation."""

    separation: Floats
    """[k] [m]"""
    rssi: Floats
    """[k] [dBm]"""
    threshold: float
    """Least power that decodes [dBm]."""

    @property
    def are_decoded(self) -> bool:
        """True if the file holds the power of decoded packets only: none is below the threshold."""
        return bool((self.rssi >= self.threshold).all())


def threshold(noise_floor: float | None, sensitivity: float | None, spectral_efficiency: float) -> float | None:
    """Least power that decodes [dBm]; None if neither flag is given.

    It is the sensitivity, or by (3) the noise times 2^delta - 1. Raises FesError if both are given.
    """
    if noise_floor is not None and sensitivity is not None:
        raise FesError("give --noise-floor or --sensitivity, not both: each determines the least power that decodes")
    if noise_floor is not None:
        return noise_floor + 10.0 * float(np.log10(np.exp2(spectral_efficiency) - 1.0))
    return sensitivity


def read(path: Path, least_power: float | None) -> Packets | Powers:
    """The measurements of a file; of received power if `least_power` [dBm] is given. Raises FesError in one line."""
    try:
        content = files.read(path, LARGEST)
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error, with_file=False)}") from None
    wanted = (_DECODED, _RSSI) if least_power is None else (_RSSI, _DECODED)
    columns = number_columns.read(str(path), content, ((_SEPARATION,), wanted))
    separation = columns["separation"]
    if "rssi" in columns:
        if least_power is None:
            raise FesError(f"{path} has received power: give --noise-floor or --sensitivity, the least that decodes")
        _check_separations(path, separation)
        return Powers(separation, columns["rssi"], least_power)
    if least_power is not None:
        raise FesError(f"{path} has no column rssi, so --noise-floor and --sensitivity have no effect")
    decoded = columns["decoded"] == 1.0
    if decoded.all() or not decoded.any():
        state = "decoded" if decoded.all() else "were lost"
        raise FesError(f"{path}: all {len(decoded)} packets {state}: a fit needs decoded and lost ones")
    _check_separations(path, separation)
    return Packets(separation, decoded)


def _check_separations(path: Path, separation: Floats) -> None:
    if separation.min() == separation.max():
        raise FesError(f"{path}: all rows have one separation, {separation[0]:g} m: a fit needs at least two")
