"""Dryden turbulence of MIL-F-8785C at medium and high altitude, with rate gusts of physical sign."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aerosim.world.process import GaussProcess


def dryden_processes(
    sigma: float,
    length: float,
    airspeed: float,
    span: float,
    dt: float,
    rng_of: Callable[[str], np.random.Generator],
) -> tuple[GaussProcess, GaussProcess, GaussProcess, GaussProcess]:
    """Gusts of equal sigma and length in the three axes, as a frozen field flown through.

    sigma: m/s; length: m (533.4 is 1750 ft); airspeed: m/s; span: m; dt: s.  Returns the processes of
    (u), (v, r), (w, q), (p): velocities m/s, rates rad/s.  Rates are the rotation of the air itself:
    q = -dw/dx and r = +dv/dx, x forward, d/dx = (1/V) d/dt.  Source: MIL-F-8785C, 3.7.2, forming filters
    H_u, H_v, H_w, and the spectra Phi_p, Phi_q, Phi_r with their span filters.
    """
    tau = length / airspeed
    u = GaussProcess([[-1.0 / tau]], [[sigma * np.sqrt(2.0 / tau)]], [[1.0]], dt, rng_of("air.turbulence.u"))
    v = _transverse(sigma, tau, airspeed, 3.0 * span / (np.pi * airspeed), +1.0, dt, rng_of("air.turbulence.v"))
    w = _transverse(sigma, tau, airspeed, 4.0 * span / (np.pi * airspeed), -1.0, dt, rng_of("air.turbulence.w"))
    p_tau = 4.0 * span / (np.pi * airspeed)
    p_density = sigma**2 / (airspeed * length) * 0.8 * (np.pi * length / (4.0 * span)) ** (1.0 / 3.0)
    # one-sided density in rad/s: white noise of unit intensity has 1/pi
    p = GaussProcess(
        [[-1.0 / p_tau]], [[np.sqrt(np.pi * p_density) / p_tau]], [[1.0]], dt, rng_of("air.turbulence.p")
    )
    return u, v, w, p


def _transverse(
    sigma: float, tau: float, airspeed: float, rate_tau: float, sign: float, dt: float, rng: np.random.Generator
) -> GaussProcess:
    """sigma sqrt(tau) (1 + sqrt(3) tau s)/(1 + tau s)^2 and sign (s/V)/(1 + rate_tau s) of it."""
    k = sigma * np.sqrt(tau)
    # x0 = tau^2/(1 + tau s)^2 of white noise, x1 its derivative, x2 = the gust through the span filter
    gust = np.array([1.0, np.sqrt(3.0) * tau]) / tau**2
    a = np.zeros((3, 3))
    a[0, 1] = 1.0
    a[1] = [-1.0 / tau**2, -2.0 / tau, 0.0]
    a[2, :2] = gust / rate_tau
    a[2, 2] = -1.0 / rate_tau
    rate = sign / (airspeed * rate_tau) * np.array([gust[0], gust[1], -1.0])
    # sigma stands outside of the states: another sigma gives the same gusts, only stronger
    return GaussProcess(a, [[0.0], [1.0], [0.0]], k * np.vstack([[*gust, 0.0], rate]), dt, rng)
