# SPDX-License-Identifier: GPL-2.0-or-later
"""Fields of the elements as MDAnalysis' auxiliary data: an array of elements at each frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from MDAnalysis.auxiliary.base import AuxReader, AuxStep
from numpy.typing import NDArray

Fields = Mapping[str, NDArray[Any]]


class FieldStep(AuxStep):
    """The fields of one frame."""

    def _select_time(self, key: None) -> None:
        """Times follow from the step: MDAnalysis warns where this is missing."""

    def _select_data(self, key: str | None) -> NDArray[Any] | None:
        return None if key is None else self._data[key]


class ElementFields(AuxReader):
    """Reader of fields that lie in memory, one step a frame.

    ``trajectory.add_auxiliary(None, ElementFields(fields, dt=dt))`` makes each of them an attribute
    of ``trajectory.ts.aux``.

    Parameters
    ----------
    auxdata : mapping of ndarray
        Fields by name, (frame, element).
    **kwargs
        Of MDAnalysis' own readers: ``dt``, time between frames, and others.
    """

    format = "FLOE_FIELDS"
    _Auxstep = FieldStep

    def __init__(self, auxdata: Fields, **kwargs: Any) -> None:
        self._auxdata = auxdata
        self._n_steps = len(next(iter(auxdata.values())))
        super().__init__(**kwargs)

    @property
    def terms(self) -> list[str]:
        """Names of the fields."""
        return list(self._auxdata)

    def _memory_usage(self) -> int:
        return sum(values.nbytes for values in self._auxdata.values())

    def _read_next_step(self) -> AuxStep:
        step = self.auxstep
        if step.step + 1 >= self._n_steps:
            self._restart()
            raise StopIteration
        step.step += 1
        step._data = {name: values[step.step] for name, values in self._auxdata.items()}
        return step

    def _go_to_step(self, i: int) -> AuxStep:
        self.auxstep.step = i - 1
        return self._read_next_step()

    def read_all_times(self) -> NDArray[np.float64]:
        """Times of the frames, (frame,)."""
        return np.asarray(self.initial_time + self.dt * np.arange(self._n_steps))
