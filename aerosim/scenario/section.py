"""What every section of a scenario has in common: frozen, strict, no unknown key, no NaN."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError


class Section(BaseModel):
    """A section of the scenario file: frozen, types taken literally (a whole number passes as a number)."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


Latitude = Annotated[float, Field(ge=-90, le=90)]
Longitude = Annotated[float, Field(ge=-180, le=180)]
Point = tuple[Latitude, Longitude]
NotNegative = Annotated[float, Field(ge=0)]
NotNegativeInt = Annotated[int, Field(ge=0)]
Positive = Annotated[float, Field(gt=0)]


def wrong(problem: str, allowed: str = "", key: str = "") -> PydanticCustomError:
    """Error of a validator, carrying the parts of the message.  key: below the validated section, if any."""
    context: dict[str, Any] = {"problems": ((key, problem, allowed),)}
    return PydanticCustomError("aerosim", "wrong value", context)
