"""One step of the seeking law (18) by collocation: the filters exactly, the index at a few times at once.

In (18) only the index is nonlinear. The rest is a washout, a low-pass and an integrator. Their response to an input
known at Gauss-Legendre nodes is a matrix that is computed once. A fixed number of Picard sweeps then makes the
estimate's path and the index along it agree. Each sweep evaluates the index at all nodes of all links in one call; a
classic Runge-Kutta step would need four calls in sequence.

Sums over nodes run along the second axis of small arrays, term by term. So a link's digits do not depend on the
number of links that are computed together. Those of a matrix product would.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fes.arrays.types import Floats

NODES = 5
"""Gauss-Legendre nodes per step; fewer than 8, so that numpy adds them in order."""

_QUADRATURE = 24
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
    points, _ = np.polynomial.legendre.leggauss(NODES)
    nodes = 0.5 * (points + 1.0)
    ends = np.append(nodes, 1.0)
    high_pass = np.array([[-washout]])
    # (r_hat, xi)' = system (r_hat, xi) + from_peer r_hat_peer + from_index demodulated
    system = np.array([[-consensus, 1.0], [-sign * low_pass * consensus, -low_pass]])
    from_peer = np.array([consensus, sign * low_pass * consensus])
    from_index = np.array([0.0, low_pass])
    path_start, path_input = [], []
    for end in ends:
        peer = _response(system, from_peer, length, end, np.ones_like)[:, :1]
        path_start.append(np.hstack([_exponential(system * length * end), peer]))
        path_input.append(_response(system, from_index, length, end, lambda s: _lagrange(nodes, s)))
    rows = [part[0] for part in path_start] + [path_start[-1][1]]
    inputs = [part[0] for part in path_input] + [path_input[-1][1]]
    wash = [_response(high_pass, np.array([washout]), length, end, lambda s: _lagrange(nodes, s))[0] for end in ends]
    return Step(
        nodes=length * nodes,
        washout_start=np.exp(-washout * length * ends)[:, None],
        washout_input=np.array(wash)[:, :, None],
        path_start=np.array(rows)[:, :, None],
        path_input=np.array(inputs)[:, :, None],
    )


def _response(system: Floats, gain: Floats, length: float, end: float, shape: Callable[[Floats], Floats]) -> Floats:
    """Integral over t in [0, end * length] of exp(system * (end * length - t)) gain shape(t / length) dt."""
    points, weights = np.polynomial.legendre.leggauss(_QUADRATURE)
    times = 0.5 * end * (points + 1.0)
    kernels = np.stack([_exponential(system * length * (end - s)) @ gain for s in times], axis=1)
    return 0.5 * end * length * (kernels * weights) @ np.atleast_2d(shape(times)).reshape(len(times), -1)


def _lagrange(nodes: Floats, times: Floats) -> Floats:
    """The Lagrange polynomials of the nodes at `times` [t], both in units of the step [t, NODES]."""
    columns = []
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        columns.append(np.prod((times[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)


def _exponential(matrix: Floats) -> Floats:
    """exp of a small matrix of norm below about 10, by halving and Taylor's series."""
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(matrix).sum(), 1e-300)))) + 1)
    term = result = np.eye(len(matrix))
    for order in range(1, _TAYLOR):
        term = term @ (matrix / 2.0**halvings) / order
        result = result + term
    for _ in range(halvings):
        result = result @ result
    return result
