"""Forces, stiffnesses and energies of single contacts in Python, by the laws of the runs.

gw.contact_force("hertz", [{"shape": "sphere", "diameter": 0.01, "material": "steel"}, {"shape":
"plane"}], 1e-6)
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.lammps_inputs.case.contact.contact import LAWS
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.contact.single import contact_between_bodies
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.python.inputs import plain

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

logger = logging.getLogger(__name__)

Values = float | NDArray[np.float64]
Body = str | Mapping[str, Any]

_LARGEST = 1e3  # m, lower bound of the search for the overlap of a force
_ROUNDING = 1e-9  # relative excess of an overlap that was computed from the limit itself
_warned: set[tuple[str, float]] = set()  # law and limit of contacts that were warned about


@overload
def contact_force(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    *,
    peak_overlap: ArrayLike | None = None,
    error: Literal[False] = False,
    **options: Any,
) -> Values: ...


@overload
def contact_force(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    *,
    peak_overlap: ArrayLike | None = None,
    error: Literal[True],
    **options: Any,
) -> tuple[Values, Values]: ...


def contact_force(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    *,
    peak_overlap: ArrayLike | None = None,
    error: bool = False,
    **options: Any,
) -> Values | tuple[Values, Values]:
    """Return the force of a contact, and on request the error bar of the law.

    Parameters
    ----------
    law
        ``hertz`` (point contact of any curvatures, or line contact of two half-spaces whose
        displacement is limited by the length), ``elastoplastic``, ``elastoplastic-fe``,
        ``bilinear``, ``thornton``, ``line`` (line contact, plane strain) or ``power``.
    bodies
        Two tables with ``shape``: ``sphere``, ``cylinder``, ``plane`` or ``tube``; ``diameter`` or
        ``radius`` (m); ``length`` (m) and ``axis`` of cylinders ("x", "y", "z" or a vector; y by
        default); ``material``: a name, or a mapping as the table ``[material]``. Planes and tubes
        without a material are rigid; ``"plane"`` means a rigid plane.
    overlap
        Overlap, of any shape, m. The force is zero where it is negative, except in contacts with
        JKR cohesion, whose neck carries tension.
    peak_overlap
        Largest overlap in the history of the contact, m: for laws with a residual indentation, and
        for necks. By default the contact is loaded for the first time.
    error
        True to return the error bar as well: the largest deviation of law ``elastoplastic-fe`` from
        finite elements, N. It is NaN beyond the range of the fit, with a rate-dependent yield
        strength, with cohesion, and for other laws.
    options
        Options of the law, with the names of the keys of ``[contact]``: ``constant`` and
        ``exponent`` of law power, ``variant``, ``yield_factor``, ``beta``, constants of the
        elasto-plastic law, ``cohesion`` of spheres.

    Returns
    -------
    float or numpy.ndarray
        Force of the shape of the overlap, N; compression positive. With ``error`` a tuple of force
        and error bar.

    Raises
    ------
    InputError
        A body, the law, an option or an overlap is invalid; the message has a line for each fault.
    """
    contact, now, peak = _at(law, bodies, overlap, peak_overlap, options)
    force = _given(np.where(now > -contact.neck_length, contact.force(now, peak), 0.0))
    if not error:
        return force
    return force, _given(np.asarray(contact.force_error(now, peak)))


def contact_stiffness(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    *,
    peak_overlap: ArrayLike | None = None,
    **options: Any,
) -> Values:
    """Return the slope of the force against the overlap: of loading at the peak, of unloading below
    it.

    Parameters
    ----------
    law, bodies, overlap, peak_overlap, options
        As in `contact_force`.

    Returns
    -------
    float or numpy.ndarray
        N/m.

    Raises
    ------
    InputError
        As in `contact_force`.
    """
    contact, now, peak = _at(law, bodies, overlap, peak_overlap, options)
    return _given(np.where(now > -contact.neck_length, contact.tangent_stiffness(now, peak), 0.0))


def contact_energy(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    *,
    peak_overlap: ArrayLike | None = None,
    **options: Any,
) -> Values:
    """Return the elastic energy of a contact, which unloading recovers; plastic dissipation is
    not included.

    With cohesion it is measured from separated surfaces, and may be negative.

    Parameters
    ----------
    law, bodies, overlap, peak_overlap, options
        As in `contact_force`.

    Returns
    -------
    float or numpy.ndarray
        J.

    Raises
    ------
    InputError
        As in `contact_force`.
    """
    contact, now, peak = _at(law, bodies, overlap, peak_overlap, options)
    return _given(np.where(now > -contact.neck_length, contact.elastic_energy(now, peak), 0.0))


def contact_overlap(law: str, bodies: Sequence[Body], force: ArrayLike, **options: Any) -> Values:
    """Return the overlap at which a contact carries a force on first loading.

    Parameters
    ----------
    law, bodies, options
        As in `contact_force`.
    force
        Of any shape, N, from 0 up.

    Returns
    -------
    float or numpy.ndarray
        Overlap of the shape of the force, m.

    Raises
    ------
    InputError
        As in `contact_force`; or a force is negative or exceeds the force at the largest valid
        overlap.
    """
    contact = contact_between_bodies(law, plain(bodies), plain(options))
    wanted = _numbers("force", force, "N")
    if (wanted < 0).any():
        raise InputError(
            f"contact: force: found {show(float(wanted.min()))}, expected 0 or more (N)"
        )
    low = np.zeros_like(wanted)
    high = np.full_like(wanted, _LARGEST)
    if (contact.loading_force(high) < wanted).any():
        raise InputError(f"contact: force: found {show(float(wanted.max()))}, expected a force reached below an overlap of {_LARGEST:g} m (N)")  # fmt: skip
    middle = high / 2
    while ((low < middle) & (middle < high)).any():
        above = contact.loading_force(middle) >= wanted
        low = np.where(above, low, middle)
        high = np.where(above, middle, high)
        middle = (low + high) / 2
    found = np.where(wanted > 0, high, contact.balanced_overlap)
    _warn_beyond(contact, law, found)
    return _given(found)


def contact_yield(law: str, bodies: Sequence[Body], **options: Any) -> tuple[float, float]:
    """Return overlap alpha_y and force F_y at first yield, the units of normalised results.

    Parameters
    ----------
    law, bodies, options
        As in `contact_force`.

    Returns
    -------
    tuple of float
        Overlap (m) and force (N); infinite for laws that do not yield.

    Raises
    ------
    InputError
        As in `contact_force`.
    """
    contact = contact_between_bodies(law, plain(bodies), plain(options))
    if law not in LAWS or not LAWS[law].yields:
        return math.inf, math.inf
    return float(contact.yield_overlap), float(contact.yield_force)


def _at(
    law: str,
    bodies: Sequence[Body],
    overlap: ArrayLike,
    peak_overlap: ArrayLike | None,
    options: Mapping[str, Any],
) -> tuple[ContactLaw, NDArray[np.float64], NDArray[np.float64]]:
    """Return the law, the overlaps (in gaps 0 or the end of a neck) and the largest overlaps so
    far.
    """
    contact = contact_between_bodies(law, plain(bodies), plain(options))
    now = np.maximum(_numbers("overlap", overlap, "m"), -contact.neck_length)
    peak = (
        np.maximum(now, 0.0)
        if peak_overlap is None
        else _numbers("peak_overlap", peak_overlap, "m")
    )
    try:
        now, peak = np.broadcast_arrays(now, peak)
    except ValueError:
        raise InputError(
            f"contact: peak_overlap: found the shape {peak.shape}, expected the shape of overlap, "
            f"{now.shape}"
        ) from None
    if (peak < now).any():
        raise InputError(
            "contact: peak_overlap: found a value below the overlap, expected the largest overlap "
            "so far (m)"
        )
    _warn_beyond(contact, law, peak)
    return contact, now, peak


def _numbers(name: str, values: ArrayLike, unit: str) -> NDArray[np.float64]:
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"contact: {name}: found {show(values)}, expected a number or an array ({unit})"
        ) from None
    if not np.isfinite(found).all():
        raise InputError(
            f"contact: {name}: found a value that is not finite, expected numbers ({unit})"
        )
    return found


def _warn_beyond(contact: ContactLaw, law: str, overlap: NDArray[np.float64]) -> None:
    """Warn about an overlap beyond the range of the law, once for each contact."""
    largest = float(overlap.max(initial=0.0))
    limit = float(contact.valid_overlap)
    if largest <= limit * (1 + _ROUNDING) or (law, limit) in _warned:
        return
    _warned.add((law, limit))
    logger.warning(
        "law %s: an overlap of %.9g m is beyond %.9g m, the limit of the law for this contact",
        law,
        largest,
        limit,
    )


def _given(values: NDArray[np.float64]) -> Values:
    return float(values) if values.ndim == 0 else values
