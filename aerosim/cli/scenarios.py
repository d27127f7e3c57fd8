"""`list`, `new` and `schema`: what ships, a scenario to start from, the layout for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_columns, print_json, say
from aerosim.errors import InputError


def _shipped() -> list[dict[str, Any]]:
    from aerosim.scenario import load, shipped

    found = []
    for name in shipped():
        scenario = load(name)
        found.append({"name": name, "purpose": scenario.purpose, "verifies": list(scenario.verifies)})
    return found


def list_shipped(
    *, as_json: Json = False, quiet: Quiet = False, verbose: Verbose = 0, debug: Debug = False
) -> int:
    """List the scenarios that ship, each with its purpose."""
    found = _shipped()
    if as_json:
        print_json(found)
    else:
        print_columns([(each["name"], each["purpose"]) for each in found])
    return 0


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the scenario.")],
    *,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="File to write.  [NAME.yaml]")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file if it exists.")] = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Write a commented scenario to start from: every key with its meaning, ready to fly."""
    from aerosim.scenario.template import template

    text = template(name)
    file = out or Path(f"{name}.yaml")
    try:
        with file.open("w" if overwrite else "x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError as error:
        raise InputError("file exists", where=str(file), allowed="another --out, or --overwrite") from error
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", where=str(file)) from error
    say(f"next: aerosim check {file}, then aerosim run {file}")
    print(file)
    return 0


def schema(debug: Debug = False) -> int:
    """Print the JSON schema of the scenario file."""
    from aerosim.scenario.reference import schema as layout

    print_json(layout())
    return 0
