"""Stress of a viscoelastic grain from the history of its strain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError

_PAIR = 2  # modulus and relaxation time


def stress_history(
    time: ArrayLike,
    strain: ArrayLike,
    long_time_modulus: float,
    terms: Sequence[tuple[float, float]],
) -> NDArray[np.float64]:
    """Return the stress of a strain history in a material whose modulus relaxes.

    The relaxation modulus is a Prony series, ``E(t) = E_0 + sum of E_q exp(-t/tau_q)``, and the
    stress is the hereditary integral of ``E(t - s)`` over the strain increments at the times ``s``.
    The strain is linear between the instants; the integral is exact for such a strain.

    Parameters
    ----------
    time
        Instants, s, increasing: (n,).
    strain
        Strain at the instants: (n, ...). The strain at the first instant is applied there as a
        step; before it the material is undeformed.
    long_time_modulus
        ``E_0``, Pa; 0 or more.
    terms
        Pairs of ``E_q``, Pa, 0 or more, and relaxation time ``tau_q``, s, above 0.

    Returns
    -------
    numpy.ndarray
        Stress, Pa, with the shape of the strain.

    Raises
    ------
    InputError
        An argument is invalid.

    Examples
    --------
    >>> import granwave as gw
    >>> gw.stress_history([0.0, 1.0], [1.0, 1.0], 1.0, [(2.0, 1.0)]).round(4).tolist()
    [3.0, 1.7358]
    """
    instants = _numbers("time", time)
    strains = _numbers("strain", strain)
    _check_shapes(instants, strains)
    series = _checked_terms(terms)
    stress = _number("long_time_modulus", long_time_modulus) * strains
    for modulus, relaxation_time in series:
        stress += _stress_of_term(instants, strains, modulus, relaxation_time)
    return stress


def _stress_of_term(
    time: NDArray[np.float64], strain: NDArray[np.float64], modulus: float, relaxation_time: float
) -> NDArray[np.float64]:
    """Return the stress of one term, Pa, with the shape of the strain."""
    steps = np.diff(time) / relaxation_time
    kept = np.exp(-steps)
    added = -np.expm1(-steps) / steps
    stress = np.empty_like(strain)
    stress[0] = modulus * strain[0]
    for n, increment in enumerate(np.diff(strain, axis=0)):
        stress[n + 1] = kept[n] * stress[n] + modulus * added[n] * increment
    return stress


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if numbers.ndim == 0 or not numbers.size or not np.isfinite(numbers).all():
        raise InputError(f"{name}: expected an array of finite numbers, one row per instant")
    return numbers


def _check_shapes(time: NDArray[np.float64], strain: NDArray[np.float64]) -> None:
    if time.ndim != 1 or (np.diff(time) <= 0).any():
        raise InputError("time: expected increasing instants in s, in one dimension")
    if len(strain) != len(time):
        raise InputError(
            f"strain: found {len(strain)} rows for {len(time)} instants, expected one per instant"
        )


def _checked_terms(terms: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    found = list(terms) if isinstance(terms, Sequence | np.ndarray) else [terms]
    series = []
    for term in found:
        if not isinstance(term, Sequence | np.ndarray) or len(term) != _PAIR:
            raise InputError(
                f"terms: found {show(term)}, expected pairs of modulus (Pa) and relaxation time (s)"
            )
        modulus = _number("modulus of terms", term[0])
        relaxation_time = _number("relaxation time of terms", term[1])
        if not relaxation_time:
            raise InputError("relaxation time of terms: found 0, expected a number of s above 0")
        series.append((modulus, relaxation_time))
    return series


def _number(name: str, value: float) -> float:
    is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not is_number or not np.isfinite(value) or value < 0:
        raise InputError(f"{name}: found {show(value)}, expected a number from 0 up")
    return float(value)
