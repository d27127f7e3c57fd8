"""The scenario file: one frozen model per section, strict loading, errors that name file, line and key."""

from aerosim.scenario.checks import whole_steps
from aerosim.scenario.emit import text_of, to_yaml
from aerosim.scenario.load import (
    Override,
    absolute,
    find_scenario,
    from_mapping,
    given,
    load,
    load_scenario,
    parse_setting,
    shipped,
    variants,
    with_overrides,
)
from aerosim.scenario.scenario import Scenario

__all__ = [
    "Override",
    "Scenario",
    "absolute",
    "find_scenario",
    "from_mapping",
    "given",
    "load",
    "load_scenario",
    "parse_setting",
    "shipped",
    "text_of",
    "to_yaml",
    "variants",
    "whole_steps",
    "with_overrides",
]
