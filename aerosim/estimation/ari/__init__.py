"""ARI processes: orientation parameters filtered without a-priori variances (Lindenberger 1988; docs/ari.md)."""

from aerosim.estimation.ari.filter import Filtered, filter_ari
from aerosim.estimation.ari.fit import fit_ari
from aerosim.estimation.ari.order import OrderChoice, select_order
from aerosim.estimation.ari.prior import Prior
from aerosim.estimation.ari.process import Process, simulate_ari
from aerosim.estimation.ari.result import AriFit, Estimate, StripFit
from aerosim.estimation.ari.robust import Step
from aerosim.estimation.ari.series import resample, unwrap

__all__ = [
    "AriFit",
    "Estimate",
    "Filtered",
    "OrderChoice",
    "Prior",
    "Process",
    "Step",
    "StripFit",
    "filter_ari",
    "fit_ari",
    "resample",
    "select_order",
    "simulate_ari",
    "unwrap",
]
