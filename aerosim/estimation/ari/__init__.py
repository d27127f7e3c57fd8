"""ARI processes: orientation parameters filtered without a-priori variances (Lindenberger 1988; docs/ari.md)."""

from aerosim.estimation.ari.filter import Filtered, filter_ari
from aerosim.estimation.ari.process import Process, simulate_ari
from aerosim.estimation.ari.series import resample, unwrap

__all__ = ["Filtered", "Process", "filter_ari", "resample", "simulate_ari", "unwrap"]
