# SPDX-License-Identifier: GPL-2.0-or-later
"""Inherent optical properties of snow, sea ice and ponds in three bands of the sun's light.

All numbers are those of Briegleb and Light (2007): the visible (0.2 to 0.7 um), and the near
infrared below and above 1.19 um. Extinction is per metre; "albedo" here is the share of extinction
that scatters, "asymmetry" the mean cosine of the scattering angle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from floeflow.column.physics import jit

if TYPE_CHECKING:
    from floeflow.column.physics import Physics

BANDS = 3
# Layers of the ice: at the surface, drained, inside; the last two under ponds.
SURFACE, DRAINED, INSIDE, POND_SURFACE, POND_INSIDE = range(5)
ICE_EXTINCTION = np.array(
    [
        [1000.1, 1003.7, 7042.0],
        [100.2, 107.7, 1309.0],
        [20.2, 27.7, 1445.0],
        [70.2, 77.7, 1309.0],
        [20.2, 27.7, 1445.0],
    ]
)
ICE_ALBEDO = np.array(
    [
        [0.9999, 0.9963, 0.9088],
        [0.9980, 0.9287, 0.0305],
        [0.9901, 0.7223, 0.0277],
        [0.9972, 0.9009, 0.0305],
        [0.9901, 0.7223, 0.0277],
    ]
)
ICE_ASYMMETRY = 0.94
WATER_EXTINCTION = np.array([0.20, 12.0, 729.0])  # pond water only absorbs
OCEAN_ALBEDO = np.array([0.01, 0.0, 0.0])  # of the sea under the ice
# Change of the scattering that moves the albedo by a standard deviation, up and down.
ICE_DEVIATION, POND_MORE, POND_LESS = 0.15, 2.0, 0.5

# Radius of snow grains (um), then extinction efficiency, albedo and asymmetry in the three bands.
_SNOW_TABLE = """
   5 2.131798 2.187756 2.267358 0.9999994 0.9999673 0.9954589 0.859913 0.848003 0.824415
   7 2.104499 2.148345 2.236078 0.9999992 0.9999547 0.9938576 0.86713 0.85815 0.848445
  10 2.08158 2.116885 2.175067 0.999999 0.9999382 0.9917989 0.873381 0.867221 0.861714
  15 2.062595 2.088937 2.130242 0.9999985 0.9999123 0.9889724 0.878368 0.874879 0.874036
  20 2.051403 2.072422 2.10661 0.9999979 0.9998844 0.986619 0.881462 0.879661 0.881299
  30 2.039223 2.055389 2.080586 0.999997 0.9998317 0.9823021 0.884361 0.883903 0.890184
  40 2.032383 2.045751 2.066394 0.999996 0.99978 0.9785269 0.885937 0.886256 0.895393
  50 2.02792 2.039388 2.057224 0.9999951 0.9997288 0.9751601 0.886931 0.887769 0.899072
  65 2.023444 2.033137 2.048055 0.9999936 0.9996531 0.9706974 0.887894 0.889255 0.903285
  80 2.020412 2.02884 2.041874 0.9999922 0.9995783 0.9667577 0.888515 0.890236 0.906588
 100 2.017608 2.024863 2.036046 0.9999903 0.9994798 0.9621007 0.889073 0.891127 0.910152
 120 2.015592 2.022021 2.031954 0.9999885 0.9993825 0.9579541 0.889452 0.89175 0.9131
 140 2.014083 2.019887 2.028853 0.9999866 0.9992862 0.9541924 0.88973 0.892213 0.915621
 170 2.012368 2.017471 2.025353 0.9999838 0.9991434 0.9490959 0.890026 0.892723 0.918831
 200 2.011092 2.015675 2.022759 0.999981 0.9990025 0.944494 0.890238 0.893099 0.92154
 240 2.009837 2.013897 2.020168 0.9999772 0.9988171 0.9389141 0.890441 0.893474 0.924581
 290 2.008668 2.012252 2.017781 0.9999726 0.998589 0.9325819 0.890618 0.893816 0.927701
 350 2.007627 2.010813 2.015678 0.999967 0.9983199 0.9256405 0.890762 0.894123 0.930737
 420 2.006764 2.009577 2.01388 0.9999605 0.9980117 0.9181533 0.890881 0.894397 0.933568
 500 2.006037 2.00852 2.012382 0.999953 0.9976663 0.910154 0.890975 0.894645 0.936148
 570 2.005528 2.007807 2.011307 0.9999465 0.9973693 0.9035031 0.891035 0.894822 0.937989
 660 2.005025 2.007079 2.01028 0.9999382 0.9969939 0.8953134 0.891097 0.89502 0.939949
 760 2.004562 2.00644 2.009333 0.9999289 0.9965848 0.8865789 0.891147 0.895212 0.941727
 870 2.004155 2.005898 2.008523 0.9999188 0.9961434 0.877335 0.891189 0.895399 0.943339
1000 2.003794 2.005379 2.007795 0.9999068 0.9956323 0.8668233 0.891225 0.895601 0.944915
1100 2.003555 2.005041 2.007329 0.9998975 0.9952464 0.858999 0.891248 0.895745 0.94595
1250 2.003264 2.004624 2.006729 0.9998837 0.9946782 0.8476493 0.891277 0.895951 0.947288
1400 2.003037 2.004291 2.00623 0.9998699 0.9941218 0.8367318 0.891299 0.896142 0.948438
1600 2.002776 2.003929 2.0057 0.9998515 0.9933966 0.8227881 0.891323 0.896388 0.949762
1800 2.00259 2.003627 2.005276 0.9998332 0.9926888 0.8095131 0.89134 0.896623 0.950916
2000 2.002395 2.003391 2.004904 0.9998148 0.9919968 0.796862 0.891356 0.896851 0.951945
2500 2.002071 2.002922 2.004241 0.9997691 0.9903277 0.7677887 0.891386 0.897399 0.954156
"""
_SNOW = np.array(_SNOW_TABLE.split(), dtype=float).reshape(-1, 10)
GRAINS = np.ascontiguousarray(_SNOW[:, 0])
SNOW_EFFICIENCY = np.ascontiguousarray(_SNOW[:, 1:4])
SNOW_ALBEDO = np.ascontiguousarray(_SNOW[:, 4:7])
SNOW_ASYMMETRY = np.ascontiguousarray(_SNOW[:, 7:10])


@jit
def ice_scattering(kind: int, band: int, p: Physics) -> tuple[float, ...]:
    """Scattering and absorption of a layer of ice (1/m), scattering as tuned.

    Parameters
    ----------
    kind : int
        SURFACE, DRAINED, INSIDE, POND_SURFACE or POND_INSIDE.
    band : int
        Spectral band: 0 visible, then infrared.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Scattering and absorption coefficients (1/m), Briegleb and Light (2007).
    """
    extinction, albedo = ICE_EXTINCTION[kind, band], ICE_ALBEDO[kind, band]
    if kind >= POND_SURFACE:
        tuning = p.pond_scatter_tuning
        change = (POND_MORE if tuning >= 0.0 else POND_LESS) * tuning
    else:
        change = ICE_DEVIATION * p.ice_scatter_tuning
    return max(extinction * albedo * (1.0 + change), 0.0), extinction * (1.0 - albedo)


@jit
def grain_place(radius: float) -> tuple[int, float]:
    """Row of the table below a grain radius (um), and the share of the next row.

    Parameters
    ----------
    radius : float
        Of snow grains (um).

    Returns
    -------
    tuple of int and float
        Row and share (1).
    """
    last = GRAINS.size - 1
    if radius < GRAINS[0]:
        return 0, 0.0
    if radius >= GRAINS[last]:
        return last - 1, 1.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if radius >= GRAINS[middle]:
            low = middle
        else:
            high = middle
    return low, (radius - GRAINS[low]) / (GRAINS[low + 1] - GRAINS[low])


@jit
def snow_optics(radius: float, row: int, share: float, band: int, p: Physics) -> tuple[float, ...]:
    """Extinction (1/m), albedo and asymmetry of snow of a grain radius (um).

    Parameters
    ----------
    radius : float
        Of the grains (um).
    row : int
        Row of the tables with the next smaller grains.
    share : float
        Weight of the row after it.
    band : int
        Spectral band: 0 visible, then infrared.
    p : Physics
        Constants.

    Returns
    -------
    tuple of float
        Extinction coefficient (1/m), single-scattering albedo, asymmetry parameter.
    """
    below, above = 1.0 - share, share
    efficiency = SNOW_EFFICIENCY[row, band] * below + SNOW_EFFICIENCY[row + 1, band] * above
    albedo = SNOW_ALBEDO[row, band] * below + SNOW_ALBEDO[row + 1, band] * above
    asymmetry = SNOW_ASYMMETRY[row, band] * below + SNOW_ASYMMETRY[row + 1, band] * above
    cover = 3.0 * p.snow_density / (p.ice_density * 4.0 * radius * 1e-6)
    return efficiency * cover, albedo, asymmetry


@jit
def snow_grains(surface: float, p: Physics) -> float:
    """Radius of snow grains (um) by the temperature of the surface (degC).

    Parameters
    ----------
    surface : float
        Temperature of the surface (degC).
    p : Physics
        Constants.

    Returns
    -------
    float
        um.
    """
    warm = min(max(1.0 + surface / p.grain_warming, 0.0), 1.0)
    cold = min(max(500.0 - 250.0 * p.snow_grain_tuning, p.fresh_grain), p.melting_grain)
    return cold + (p.melting_grain - cold) * warm
