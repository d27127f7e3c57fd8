"""Writes every aircraft from its table: JSBSim model, autopilot, limits.yaml, and a README."""

from __future__ import annotations

from pathlib import Path

from maker.autopilot import autopilot_xml
from maker.beaver import TABLE as BEAVER
from maker.beech_99 import TABLE as BEECH_99
from maker.model import limits_yaml, model_xml
from maker.survey_twin import TABLE as SURVEY_TWIN
from maker.table import Table

ROOT = Path(__file__).resolve().parent
TABLES = (SURVEY_TWIN, BEECH_99, BEAVER)


def files(table: Table) -> dict[Path, str]:
    """Paths below the aircraft's folder and what is written there, without the README."""
    return {
        Path(f"{table.name}.xml"): model_xml(table),
        Path("Systems/autopilot.xml"): autopilot_xml(table),
        Path("limits.yaml"): limits_yaml(table),
    }


def write(table: Table) -> None:
    """Write an aircraft's files, without the README."""
    for path, text in files(table).items():
        target = ROOT / table.name / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")


def main() -> None:
    """Write all aircraft, then their READMEs."""
    from maker.readme import readme

    for table in TABLES:
        write(table)
        (ROOT / table.name / "README.md").write_text(readme(ROOT / table.name, table), encoding="utf-8")


if __name__ == "__main__":
    main()
