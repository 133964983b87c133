# SPDX-License-Identifier: GPL-2.0-or-later
"""What every block of a scene's keys is made of."""

from __future__ import annotations

from datetime import date, datetime
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

# No path or paragraph is longer.
LONGEST_TEXT = 4000


def key(default: Any, text: str, unit: str = "", derived: bool = False, **bounds: Any) -> Any:
    """Declare a key: its default, one line of help, its unit, its bounds.

    A derived one follows from other keys where it is not named.

    Parameters
    ----------
    default : object
        Value where the scene does not name it.
    text : str
        Line of help.
    unit : str, optional
        SI unit; empty for none.
    derived : bool, optional
        Whether it follows from other keys where it is not named.
    bounds : object
        Of pydantic's ``Field``, such as ``gt`` and ``le``.

    Returns
    -------
    object
        Field for a pydantic model.
    """
    extra: dict[str, Any] = {"unit": unit} if unit else {}
    extra |= {"derived": True} if derived else {}
    return Field(default, description=text, json_schema_extra=extra or None, **bounds)


class Block(BaseModel):
    """A group of keys. Unknown keys and non-finite numbers are refused; values do not change."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, str_max_length=LONGEST_TEXT
    )

    @field_validator("*", mode="before")
    @classmethod
    def _is_meant(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse what pydantic would take for something else: 1 for yes, seconds for a date."""
        kind = cls.model_fields[str(info.field_name)].annotation
        if kind is datetime and not isinstance(value, date) and not _says_a_date(value):
            raise PydanticCustomError(
                "date", "Input should be a date, such as 1981-12-31 or 1981-12-31 06:00"
            )
        if kind is not bool and _holds_truth(value):
            raise PydanticCustomError("truth", "Input should not be a truth value")
        return value


def _says_a_date(value: Any) -> bool:
    """Whether a value is text that is no mere number, which would count seconds."""
    if not isinstance(value, str):
        return False
    try:
        float(value)
    except ValueError:
        return True
    return False


def _holds_truth(value: Any) -> bool:
    """Whether a value, or an item of a list of lists, is true or false."""
    if isinstance(value, list | tuple):
        return any(_holds_truth(item) for item in value)
    return isinstance(value, bool)
