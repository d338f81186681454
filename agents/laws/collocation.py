"""One step of the seeking law (18) by collocation: the filters exactly, the index at a few times at once.

In (18) only the index is nonlinear. The rest is a washout, a low-pass and an integrator. Their response to an input
known at Gauss-Legendre nodes is a matrix that is computed once. A fixed number of Picard sweeps then makes the
estimate's path and the index along it agree. Each sweep evaluates the index at all nodes of all links in one call; a
classic Runge-Kutta step would need four calls in sequence.

Sums over nodes run along the second axis of small arrays, term by term. So a link's digits do not depend on the
number of links that are computed together. Those of a matrix product would.
"""

import math
from dataclasses import dataclass

import numpy as np

from fes.arithmetic import elementary, sums
from fes.arrays.types import Floats

NODES = 5
"""Gauss-Legendre nodes per step; fewer than 8, so that numpy adds them in order."""

POINTS = np.array([0.046910077030668004, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332])
"""The nodes within a step of length 1."""

_QUADRATURE = (
    (0.06405689286260563, 0.12793819534675216),
    (0.1911188674736163, 0.1258374563468283),
    (0.3150426796961634, 0.12167047292780339),
    (0.4337935076260451, 0.1155056680537256),
    (0.5454214713888396, 0.10744427011596563),
    (0.6480936519369755, 0.09761865210411388),
    (0.7401241915785544, 0.08619016153195327),
    (0.820001985973903, 0.0733464814110803),
    (0.8864155270044011, 0.05929858491543678),
    (0.9382745520027328, 0.04427743881741981),
    (0.9747285559713095, 0.028531388628933663),
    (0.9951872199970213, 0.0123412297999872),
)
"""Positive points of the Gauss-Legendre rule with 24 points on [-1, 1], and their weights."""

QUADRATURE_POINTS = np.array([sign * point for point, _ in _QUADRATURE for sign in (-1.0, 1.0)])
QUADRATURE_WEIGHTS = np.array([weight for _, weight in _QUADRATURE for _ in range(2)])
"""Of the responses: exact for the products of a Lagrange polynomial and an exponential."""

_TAYLOR = 30


@dataclass(frozen=True, eq=False)
class Step:
    """Response matrices of the linear part over one step, at the nodes and at its end."""

    nodes: Floats
    """Times of the nodes within the step [NODES] [s]."""
    washout_start: Floats
    """Response of eta, at the nodes and the end, to eta at the start [NODES + 1, 1]."""
    washout_input: Floats
    """Response of eta, at the nodes and the end, to the index at the nodes [NODES + 1, NODES, 1]."""
    path_start: Floats
    """Response of r_hat, at the nodes and the end, and of xi at the end, to (r_hat, xi, peer's r_hat) at the start
    [NODES + 2, 3, 1]."""
    path_input: Floats
    """Response of the same to the demodulated index at the nodes [NODES + 2, NODES, 1]."""


def step(length: float, low_pass: float, washout: float, consensus: float, sign: float) -> Step:
    """The linear part of (18) over `length` [s].

    `low_pass` and `washout` are the cut-offs [rad/s], and `consensus` is kappa [1/s], 0 for a link without a peer.
    `sign` is that of the kappa term in xi': -1 as printed, +1 for consensus.
    """
    ends = np.append(POINTS, 1.0)
    high_pass = np.array([[-washout]])
    # (r_hat, xi)' = system (r_hat, xi) + from_peer r_hat_peer + from_index demodulated
    system = np.array([[-consensus, 1.0], [-sign * low_pass * consensus, -low_pass]])
    from_peer = np.array([consensus, sign * low_pass * consensus])
    from_index = np.array([0.0, low_pass])
    own = _exponential(system * (length * ends)[:, None, None])
    peer = _response(system, from_peer, length, ends, constant=True)
    index = _response(system, from_index, length, ends)
    starts = np.concatenate([own, peer], axis=2)
    return Step(
        nodes=length * POINTS,
        washout_start=elementary.exp(-washout * length * ends)[:, None],
        washout_input=_response(high_pass, np.array([washout]), length, ends)[:, 0, :, None],
        path_start=np.concatenate([starts[:, 0], starts[-1:, 1]])[:, :, None],
        path_input=np.concatenate([index[:, 0], index[-1:, 1]])[:, :, None],
    )


def _response(system: Floats, gain: Floats, length: float, ends: Floats, *, constant: bool = False) -> Floats:
    """Integral over t in [0, end * length] of exp(system * (end * length - t)) gain shape(t / length) dt.

    One for each of the `ends` [e], with the Lagrange polynomials of POINTS as shapes, or the `constant` 1: [e, k, s].
    """
    times = 0.5 * ends[:, None] * (QUADRATURE_POINTS + 1.0)
    spans = length * (ends[:, None] - times)
    kernels = sums.product(_exponential(system * spans[:, :, None, None]), gain[:, None])[..., 0]
    shapes = np.ones((*times.shape, 1)) if constant else _lagrange(times)
    weighted = (0.5 * ends * length)[:, None, None] * kernels * QUADRATURE_WEIGHTS[:, None]
    return sums.product(np.swapaxes(weighted, 1, 2), shapes)


def _lagrange(times: Floats) -> Floats:
    """The Lagrange polynomials of POINTS at `times` [...], both in units of the step [..., NODES]."""
    columns = []
    for j, node in enumerate(POINTS.tolist()):
        column = np.ones_like(times)
        for zero in np.delete(POINTS, j).tolist():
            column = column * ((times - zero) / (node - zero))
        columns.append(column)
    return np.stack(columns, axis=-1)


def _exponential(matrices: Floats) -> Floats:
    """exp of small matrices [..., k, k] of norms below about 10, by halving and Taylor's series."""
    largest = float(np.abs(matrices).max(initial=0.0)) * matrices.shape[-1]
    halvings = max(0, math.frexp(largest)[1] + 1)
    scaled = matrices * math.ldexp(1.0, -halvings)
    term = result = np.broadcast_to(np.eye(matrices.shape[-1]), matrices.shape)
    for order in range(1, _TAYLOR):
        term = sums.product(term, scaled) / order
        result = result + term
    for _ in range(halvings):
        result = sums.product(result, result)
    return result
