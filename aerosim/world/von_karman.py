"""Von Karman turbulence of MIL-F-8785C through rational filters, with rate gusts of physical sign."""

from __future__ import annotations

from math import sqrt

from aerosim.world.forming import filtered_noise
from aerosim.world.process import GaussProcess
from aerosim.world.turbulence import RngOf, Turbulence, pitch_rate, roll_process, yaw_rate

A = 1.339
# (1 + s)^(1/6) as prod (1 + s/zero)/(1 + s/pole): least fourth powers of the error in log |.|^2 from 0.03 to 5000
# rad/s, where it stays below 1.4 %.  In units of V/(1.339 L): at L 762 m and 70 m/s up to 54 Hz.
ZEROS = (1.72300, 9.19380, 55.3287, 334.862, 2120.75)
POLES = (2.20372, 12.3844, 74.6722, 452.479, 2976.46)


def von_karman_processes(
    air: Turbulence, airspeed: float, span: float, dt: float, rng_of: RngOf
) -> tuple[GaussProcess, GaussProcess, GaussProcess, GaussProcess]:
    """Gusts of a frozen field flown through, as `dryden_processes` gives them: (u), (v, r), (w, q), (p).

    Source: MIL-F-8785C, 3.7.1.1 and 3.7.2.  With x = 1.339 L omega/V the one-sided densities are
    Phi_u = 2 sigma^2 L/(pi V) (1 + x^2)^(-5/6),
    Phi_v, Phi_w = sigma^2 L/(pi V) (1 + 8/3 x^2) (1 + x^2)^(-11/6);
    Phi_p, Phi_q, Phi_r as for Dryden, with these.
    """
    tau_u, tau_w = air.length_u / airspeed, air.length_w / airspeed

    def along(tau: float) -> list[tuple[float, float]]:
        return [(0.0, A * tau), *_sixth_root(A * tau)]

    def transverse(tau: float) -> list[tuple[float, float]]:
        return [(0.0, A * tau), (sqrt(8.0 / 3.0) * A * tau, A * tau), *_sixth_root(A * tau)]

    u = filtered_noise(air.sigma_u * sqrt(2.0 * tau_u), along(tau_u), dt, rng_of("air.turbulence.u"))
    v = filtered_noise(
        air.sigma_u * sqrt(tau_u), transverse(tau_u), dt, rng_of("air.turbulence.v"), yaw_rate(airspeed, span)
    )
    w = filtered_noise(
        air.sigma_w * sqrt(tau_w), transverse(tau_w), dt, rng_of("air.turbulence.w"), pitch_rate(airspeed, span)
    )
    return u, v, w, roll_process(air, airspeed, span, dt, rng_of("air.turbulence.p"))


def _sixth_root(tau: float) -> list[tuple[float, float]]:
    """Sections of (1 + tau s)^(1/6)."""
    return [(tau / zero, tau / pole) for zero, pole in zip(ZEROS, POLES, strict=True)]
