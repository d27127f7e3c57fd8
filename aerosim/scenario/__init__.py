"""The scenario file: one frozen model per section, strict loading, errors that name file, line and key."""

from aerosim.scenario.checks import whole_steps
from aerosim.scenario.emit import to_yaml
from aerosim.scenario.load import (
    Override,
    from_mapping,
    load,
    load_scenario,
    parse_setting,
    shipped,
    with_overrides,
)
from aerosim.scenario.scenario import Scenario

__all__ = [
    "Override",
    "Scenario",
    "from_mapping",
    "load",
    "load_scenario",
    "parse_setting",
    "shipped",
    "to_yaml",
    "whole_steps",
    "with_overrides",
]
