"""Defaults that follow from control.mode and estimation.aiding, for keys that the scenario does not set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from aerosim.scenario.section import Section

# Schmelovsky (1988): the summary measures the angle between the aircraft's axis and the route, one strip is
# recognised after the other, minima are whole pixels and exposures, and gamma is printed as 0.01.
MODE_DEFAULTS: Mapping[str, Mapping[str, Any]] = {
    "schmelovsky_1988": {
        "ccd_rows": {"mounted_on": "airframe", "extension": "padded"},
        "estimation": {
            "strip_period_s": None,
            "subpixel": False,
            "aiding": "none",
            "crab": {"gamma": 0.01},
            "vh": {"gamma": 0.01},
        },
    },
    # gnss and ins have their own defaults; nothing reads gyroscopes and accelerometers beside them
    "gnss_ins": {"navigation": {"imu": None}},
}

# Mode best by its aiding (none: a studied value, and what measured best on JSBSim flights): walk that the aid does
# not see, and the noise with which the filter begins before it has learned its own.
BEST: Mapping[str, Mapping[str, Any]] = {
    "none": {
        "crab": {"walk_deg2_per_s": 0.0225, "sigma_deg": 1.0},
        "vh": {"walk_pct2_per_s": 0.03, "sigma_pct": 2.0},
    },
    "gyro": {
        "crab": {"walk_deg2_per_s": 0.002, "sigma_deg": 0.15},
        "vh": {"walk_pct2_per_s": 0.1, "sigma_pct": 0.3},
    },
    "bank": {
        "crab": {"walk_deg2_per_s": 0.003, "sigma_deg": 0.15},
        "vh": {"walk_pct2_per_s": 0.1, "sigma_pct": 0.3},
    },
    "imu": {
        "crab": {"walk_deg2_per_s": 0.00003, "sigma_deg": 0.15},
        "vh": {"walk_pct2_per_s": 0.001, "sigma_pct": 0.3},
    },
}
BEST_STRIP_PERIOD_S = 0.25


def _set_only(value: Any) -> Any:
    return value.model_dump(exclude_unset=True, by_alias=True) if isinstance(value, Section) else value


def _filled(given: Any, defaults: Mapping[str, Any]) -> Any:
    given = _set_only(given)
    if not isinstance(given, dict):
        return given  # wrong type: the validation says so
    out = dict(given)
    for key, value in defaults.items():
        if isinstance(value, Mapping):
            out[key] = _filled(out.get(key, {}), value)
        else:
            out.setdefault(key, value)
    return out


def with_mode_defaults(data: Any) -> Any:
    """Scenario data (before validation) with the defaults of mode and aiding filled in where nothing is set."""
    control = _set_only(data.get("control")) if isinstance(data, dict) else None
    mode = control.get("mode") if isinstance(control, dict) else None
    filled = _filled(data, _defaults_of(mode, data) if isinstance(mode, str) else {})
    return _filled(filled, _unit_of(filled) if isinstance(filled, dict) else {})


def _defaults_of(mode: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Defaults of a mode; a table of disturbances brings its own gamma."""
    defaults, given = MODE_DEFAULTS.get(mode, {}), _set_only(data.get("estimation"))
    if mode == "best":
        aiding = given.get("aiding", "none") if isinstance(given, dict) else "none"
        known = BEST.get(aiding, {}) if isinstance(aiding, str) else {}
        return {"estimation": {"strip_period_s": BEST_STRIP_PERIOD_S, **known}}
    if not isinstance(given, dict) or given.get("table") is None or "estimation" not in defaults:
        return defaults
    kept = {key: value for key, value in defaults["estimation"].items() if key not in ("crab", "vh")}
    return {**defaults, "estimation": kept}


def _unit_of(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The inertial unit that estimation.aiding needs, read with the rows; nothing else is aboard."""
    estimation, rows = _set_only(data.get("estimation")), _set_only(data.get("ccd_rows"))
    if not isinstance(estimation, dict) or estimation.get("aiding") not in ("gyro", "bank", "imu"):
        return {}
    period = rows.get("period_s") if isinstance(rows, dict) else None
    unit = {} if period is None else {"period_s": period}
    return {"navigation": {"gnss": None, "ins": None, "imu": unit, "smooth": None}}
