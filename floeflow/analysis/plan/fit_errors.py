# SPDX-License-Identifier: GPL-2.0-or-later
"""Fit the error model to accuracy studies."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from statistics import median

import numpy as np
import xarray as xr

from floeflow.analysis.estimate.conditions import conditions
from floeflow.analysis.plan.fit_costs import base_scene
from floeflow.analysis.plan.precision import resolutions
from floeflow.analysis.studies.measures import KEPT
from floeflow.analysis.studies.numerical_settings import numerical_settings
from floeflow.scene import Scene
from floeflow.scene.load import read_resolved
from floeflow.state import read_dataset

# Errors below this are round-off or chaos and say nothing of a law.
LEAST_ERROR = 1.0e-7


@dataclass(frozen=True)
class Study:
    """An accuracy study: errors of its stable runs by setting, level and kept norm."""

    scene: Scene
    runs: xr.Dataset

    def series(self, setting: str, norm: str) -> tuple[np.ndarray, np.ndarray]:
        """Levels and errors of a setting in a norm, without round-off.

        Parameters
        ----------
        setting : str
            Numerical setting.
        norm : str
            Of the error.

        Returns
        -------
        tuple of ndarray
            Level relative to the scene's own, and relative error, (k,) each.
        """
        rows = (self.runs["setting"].values == setting) & (self.runs["stable"].values == 1)
        level = self.runs["level"].values[rows]
        error = self.runs["error"].sel(norm=norm).values[rows]
        good = np.isfinite(error) & (error > LEAST_ERROR)
        return level[good], error[good]


def read_studies(folders: Iterable[Path]) -> list[Study]:
    """Accuracy studies of ``results/<scene>/<study>``: the folders with an ``accuracy.nc``.

    Parameters
    ----------
    folders : iterable of Path
        ``results/<scene>/<study>``.
    """
    return [
        Study(read_resolved(base_scene(f)), read_dataset(f / "accuracy.nc"))
        for f in folders
        if (f / "accuracy.nc").is_file()
    ]


def fit_laws(studies: Iterable[Study]) -> dict[str, dict[str, tuple[float, float]]]:
    """Factor and order of each setting's error in each kept norm.

    Parameters
    ----------
    studies : iterable of Study
        Of the example scenes.

    Notes
    -----
    Within a scene the slope of log error over log x; over the scenes the median slope, and the
    factor that is the geometric mean at each scene's own setting.
    """
    series: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray, float]]] = {}
    for study in studies:
        own = resolutions(study.scene, conditions(study.scene))
        for (setting, x), norm in product(own.items(), KEPT):
            level, error = study.series(setting, norm)
            if len(level) >= 2:
                pair = (np.log(level), np.log(error), math.log(x))
                series.setdefault((setting, norm), []).append(pair)
    model: dict[str, dict[str, tuple[float, float]]] = {}
    for (setting, norm), parts in series.items():
        order = median(float(np.polyfit(level, error, 1)[0]) for level, error, _ in parts)
        order = min(max(order, 0.0), 3.0)
        at_own = [float(np.mean(error - order * level)) for level, error, _ in parts]
        factor = float(np.mean([e - order * x for e, (_, _, x) in zip(at_own, parts, strict=True)]))
        model.setdefault(setting, {})[norm] = (math.exp(factor), order)
    return model


def fit_choices(studies: Iterable[Study]) -> dict[str, dict[str, dict[str, float]]]:
    """Error of each value of the settings that are choices: geometric mean over the scenes.

    Parameters
    ----------
    studies : iterable of Study
        Of the example scenes.
    """
    found: dict[tuple[str, str, str], list[float]] = {}
    for study in studies:
        varied = [setting for setting in numerical_settings(study.scene) if setting.ways]
        for setting, norm in product(varied, KEPT):
            for level, error in zip(*study.series(setting.name, norm), strict=True):
                found.setdefault((setting.name, setting.told(level), norm), []).append(error)
    model: dict[str, dict[str, dict[str, float]]] = {}
    for (name, value, norm), errors in found.items():
        mean = math.exp(float(np.mean(np.log(errors))))
        model.setdefault(name, {}).setdefault(value, {})[norm] = mean
    return model
