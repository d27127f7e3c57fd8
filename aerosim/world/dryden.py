"""Dryden turbulence of MIL-F-8785C, with rate gusts of physical sign."""

from __future__ import annotations

from math import sqrt

from aerosim.world.forming import filtered_noise
from aerosim.world.process import GaussProcess
from aerosim.world.turbulence import RngOf, Turbulence, pitch_rate, roll_process, yaw_rate


def dryden_processes(
    air: Turbulence, airspeed: float, span: float, dt: float, rng_of: RngOf
) -> tuple[GaussProcess, GaussProcess, GaussProcess, GaussProcess]:
    """Gusts of a frozen field flown through.  airspeed: m/s; span: m; dt: s.

    Returns the processes of (u), (v, r), (w, q), (p): velocities m/s, rates rad/s.  Rates are the rotation of the
    air itself: q = -dw/dx and r = +dv/dx, x forward, d/dx = (1/V) d/dt.  Source: MIL-F-8785C, 3.7.2, forming
    filters H_u, H_v, H_w, and the spectra Phi_p, Phi_q, Phi_r with their span filters.
    """
    tau_u, tau_w = air.length_u / airspeed, air.length_w / airspeed

    def transverse(tau: float) -> list[tuple[float, float]]:
        return [(0.0, tau), (sqrt(3.0) * tau, tau)]

    u = filtered_noise(air.sigma_u * sqrt(2.0 * tau_u), [(0.0, tau_u)], dt, rng_of("air.turbulence.u"))
    v = filtered_noise(
        air.sigma_u * sqrt(tau_u), transverse(tau_u), dt, rng_of("air.turbulence.v"), yaw_rate(airspeed, span)
    )
    w = filtered_noise(
        air.sigma_w * sqrt(tau_w), transverse(tau_w), dt, rng_of("air.turbulence.w"), pitch_rate(airspeed, span)
    )
    return u, v, w, roll_process(air, airspeed, span, dt, rng_of("air.turbulence.p"))
