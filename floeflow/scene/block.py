# SPDX-License-Identifier: GPL-2.0-or-later
"""What every block of a scene's keys is made of."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

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
