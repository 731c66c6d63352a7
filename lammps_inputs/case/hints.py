"""Hints for invalid input: usual magnitudes of values in SI units, and keys with another name or in
another table.
"""

from __future__ import annotations

import dataclasses
import difflib
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any

# Smallest and largest accepted magnitudes by unit; results beyond them would be meaningless. Zero
# is always accepted here; the bounds of a key may exclude it.
POSSIBLE: dict[str, tuple[float, float]] = {
    "m": (1e-18, 1e6),
    "m^2": (1e-36, 1e12),
    "s": (1e-18, 1e9),
    "m/s": (1e-15, 1e8),
    "m/s^2": (1e-12, 1e12),
    "rad/s": (1e-15, 1e12),
    "Hz": (1e-9, 1e18),
    "1/s": (1e-9, 1e18),
    "kg": (1e-24, 1e15),
    "kg/m^3": (1e-6, 1e9),
    "Pa": (1e-6, 1e18),
    "N": (1e-24, 1e18),
    "N/m": (1e-12, 1e24),
    "N s/m": (1e-15, 1e24),
    "diameters": (1e-9, 2.0),
}
_EXPONENTS = {  # powers of ten of the SI unit
    "GPa": 9, "MPa": 6, "kPa": 3, "g/cm^3": 3, "mm": -3, "µm": -6, "mm^2": -6, "cm^2": -4, "µs": -6, "ms": -3, "ns": -9,
    "mm/s": -3, "mm/s^2": -3, "kN": 3, "mN": -3, "g": -3, "kHz": 3, "MHz": 6,
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Usual:
    """Unit and usual magnitudes of a key.

    Attributes
    ----------
    unit
        SI unit; empty if there is none.
    units
        Units other than SI that users often mean, the most likely first.
    beyond
        Factor above ``high`` up to which there is no warning; for bodies that represent rigid or
        heavy bodies.
    """

    unit: str
    low: float
    high: float
    units: tuple[str, ...] = ()
    beyond: float = 1.0


LENGTH = Usual("m", 1e-9, 1e2, ("mm", "µm"))
DIAMETER = Usual("m", 1e-6, 1.0, ("mm", "µm"))  # diameter of spheres: powders to boulders
AREA = Usual("m^2", 1e-10, 1.0, ("mm^2", "cm^2"))
TIME = Usual("s", 1e-10, 0.5, ("µs", "ms"))  # time of a run or a pulse
INTERVAL = Usual("s", 1e-13, 0.5, ("ns", "µs"))  # interval of steps or records
VELOCITY = Usual("m/s", 1e-6, 1e3, ("mm/s",))
SPIN = Usual("rad/s", 1e-6, 1e6)  # angular velocity, rad/s
FREQUENCY = Usual("Hz", 0.1, 1e8, ("kHz", "MHz"))
ACCELERATION = Usual("m/s^2", 1e-3, 5e3, ("mm/s^2",))
DISPLACEMENT = Usual("m", 1e-12, 0.1, ("µm", "mm"))
FORCE = Usual("N", 1e-9, 1e9, ("kN", "mN"))
PRESSURE = Usual("Pa", 10.0, 1e10, ("MPa", "kPa"))
MASS = Usual("kg", 1e-9, 1e6, ("g",))
YOUNGS_MODULUS = Usual("Pa", 1e6, 1e12, ("GPa", "MPa"), beyond=100.0)  # rubber to diamond
YIELD_STRENGTH = Usual("Pa", 1e4, 5e10, ("MPa", "GPa"), beyond=1e4)
DENSITY = Usual("kg/m^3", 10.0, 3e4, ("g/cm^3",), beyond=100.0)  # foam to osmium
FRICTION = Usual("", 0.0, 2.0)


def impossible(value: Any, unit: str) -> str:
    """Return the accepted magnitudes if a value, or a number in it, lies outside them; empty
    otherwise.
    """
    low, high = POSSIBLE.get(unit, (0.0, float("inf")))
    if all(not number or low <= abs(number) <= high for number in _numbers(value)):
        return ""
    return f"a magnitude from {plain(low)} to {plain(high)} {unit}"


def unusual(value: Any, usual: Usual) -> str:
    """Return a warning with found and expected magnitude if a number in a value is unusual; empty
    otherwise.
    """
    most = usual.high * usual.beyond
    of_unit = f" {usual.unit}" if usual.unit else ""
    odd = next(
        (number for number in _numbers(value) if number and not usual.low <= abs(number) <= most),
        None,
    )
    if odd is None:
        return ""
    shown = plain(odd)
    text = (
        f"found {shown}{of_unit}, expected about {plain(usual.low)} to {plain(usual.high)}{of_unit}"
    )
    for other in usual.units:
        meant = odd * 10.0 ** _EXPONENTS[other]
        if usual.low <= abs(meant) <= usual.high:
            return f"{text}; {shown} {other} is {plain(meant) if 'e' in shown else f'{shown}e{_EXPONENTS[other]}'}"
    return text


def _numbers(value: Any) -> list[float]:
    """Return the numbers in a value and in the lists within it."""
    if isinstance(value, list | tuple):
        return [*chain.from_iterable(map(_numbers, value))]
    return [float(value)] if isinstance(value, int | float) else []


def plain(number: float) -> str:
    """Write a number in its usual notation: 1e6, 0.01."""
    return re.sub(r"e([+-])0*", lambda match: "e-" if match[1] == "-" else "e", f"{number:g}")


def _each_word(words_of: Mapping[str, str]) -> dict[str, str]:
    """Return the key of each word, from the words of each key in one text."""
    keys = dict[str, str]()
    for key, words in words_of.items():
        keys |= dict.fromkeys(words.split(), key)
    return keys


# `difflib` ratios: same table, other tables, same table as a last resort
_ALIKE = 0.75
_SIMILAR = 0.8
_FAINT = 0.5
_MOST = 2  # most keys of other tables in a hint

_KEY_OF_WORD = _each_word(
    {
        "velocity": "speed v v0 impact_speed impact_velocity initial_velocity striker_velocity",
        "friction": "mu mu_s friction_coefficient coefficient_of_friction coulomb sliding_friction",
        "rolling": "mu_r mu_roll rolling_friction rolling_resistance rolling_coefficient rolling_friction_coefficient",
        "twisting": "mu_twist twisting_friction torsion spinning_friction twisting_resistance torsional_friction",
        "cohesion": "adhesion surface_energy work_of_adhesion jkr dmt stickiness",
        "youngs_modulus": "e young youngs young_modulus e_modulus elastic_modulus elasticity modulus stiffness",
        "poisson_ratio": "nu poisson poissons_ratio poisson_number",
        "density": "rho mass_density specific_mass",
        "yield_strength": "sigma_y sigma_yield yield yield_stress yield_limit strength",
        "diameter": "radius r d dia sphere_diameter sphere_radius bead_diameter particle_diameter grain_size",
        "timestep": "dt time_step step stepsize delta_t",
        "end_time": "t_end tend end time total_time stop_time run_time simulation_time t_max tmax",
        "frames": "snapshots n_frames n_snapshots dumps dump_every output_frames",
        "size": "n nx ny nz count number n_spheres n_beads beads dimensions",
        "kind": "lattice structure arrangement type",
        "diameter_scatter": "scatter tolerance polydispersity dispersion size_scatter",
        "vacancies": "porosity vacancy holes defects missing",
        "tilt": "slope inclination lean leaning",
        "offset": "eccentricity off_centre off_center",
        "misalignment": "misaligned jitter",
        "bottom": "floor base ground support",
        "sides": "side lateral side_walls periodic",
        "precompression": "preload precompress prestress preloading static_load",
        "amplitude": "peak peak_force load_force force_amplitude",
        "elements": "mesh n_elements resolution nodes",
        "probes": "probe",
        "initial_overlap": "dents initial_dents dent",
        "law": "contact_law model contact_model",
        "share": "fraction portion percentage concentration",
        "replace": "inclusion inclusions intruder intruders impurity impurities substitution",
        "material": "stainless steel alloy metal",
        "name": "title label",
    }
)
_WITHIN = {
    "packing.shape": "size",
    "load.force": "amplitude",
    "load.time": "duration",
    "load.length": "duration",
    "load.period": "frequency",
}
_NOTES = {
    "restitution": "use contact.loss = {restitution = 0.9, velocity = 1.0}; otherwise restitution "
    "follows from the contact law",
    "gravity": 'use [precompression] with kind = "gravity" and, if needed, acceleration',
    "damping": "contacts dissipate energy by yielding (contact.law), contact.friction and contact.loss = {dashpot = 0.1}",
    "gamma_t": "use contact.loss = {dashpot = 0.1, tangential = 1.0}, with contact.friction",
    "ranks": "the number of MPI ranks is given on the command line: --np",
}
_OTHER_WORDS = {
    "restitution": "cor e_n coefficient_of_restitution",
    "gravity": "g gravitation gravity_acceleration",
    "damping": "viscosity dashpot gamma gamma_n",
    "gamma_t": "x_gamma_t xt tangential_damping tangential_loss loss_tangential shear_damping",
    "ranks": "np threads cores processors",
}
_NOTES |= {word: _NOTES[known] for word, known in _each_word(_OTHER_WORDS).items()}


def hint_for(name: str, known: Collection[str], prefix: str, vocabulary: Sequence[str] = ()) -> str:
    """Suggest the intended key for an unknown key.

    Parameters
    ----------
    known
        Keys of the table in which it was found.
    prefix
        Dotted name of that table; empty for the top level.
    vocabulary
        Dotted keys of all tables.
    """
    word = name.lower().replace("-", "_")
    here = difflib.get_close_matches(word, known, n=1, cutoff=_ALIKE)
    if here and _KEY_OF_WORD.get(word) not in known:
        return f"did you mean {here[0]}?"
    table = ".".join(part for part in prefix.split(".") if not part.isdigit())
    meant = _WITHIN.get(f"{table}.{word}") or _KEY_OF_WORD.get(word)
    if meant in known:
        return f"did you mean {f'{prefix}.{meant}' if prefix else meant}?"
    if word in _NOTES:
        return _NOTES[word]
    if f"{table}.{word}" in vocabulary:  # a table whose keys depend on its kind
        return f"[{table}] has this key only with another kind; available here: {', '.join(known)}"
    elsewhere = _elsewhere([word], vocabulary) or (_elsewhere([meant], vocabulary) if meant else [])
    if not elsewhere:
        last_parts = list(dict.fromkeys(key.rpartition(".")[2] for key in vocabulary))
        elsewhere = _elsewhere(
            difflib.get_close_matches(word, last_parts, cutoff=_SIMILAR), vocabulary
        )
    if elsewhere:
        there = [
            f"{key}, outside [{prefix}]" if prefix and "." not in key else key for key in elsewhere
        ]
        return f"did you mean {' or '.join(there[:_MOST])}?"
    faint = difflib.get_close_matches(word, known, n=1, cutoff=_FAINT)
    return f"did you mean {faint[0]}?" if faint else "available here: " + ", ".join(known)


def _elsewhere(words: Iterable[str], vocabulary: Sequence[str]) -> list[str]:
    """Return the dotted keys that end in one of the words; numbered tables only if no other table
    has them.
    """
    found = []
    for word in words:
        for key in vocabulary:
            if key.rpartition(".")[2] == word:
                found.append(key)
    return [key for key in found if not any(part.isdigit() for part in key.split("."))] or found
