"""Suggestions for unknown keys: similar spelling, the same key in another table, or a synonym."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence

_ALIKE, _SIMILAR, _FAINT = 0.75, 0.8, 0.5  # `difflib` ratios: same table, other tables, same table as a last resort
_MOST = 2  # keys of other tables in a hint

_KEY_OF_WORD = {
    word: key
    for key, words in {
        "velocity": "speed v v0 impact_speed impact_velocity initial_velocity striker_velocity",
        "friction": "mu mu_s friction_coefficient coefficient_of_friction coulomb sliding_friction",
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
        "bottom": "wall floor base ground support",
        "sides": "side lateral side_walls walls periodic",
        "precompression": "preload precompress prestress preloading static_load",
        "amplitude": "peak peak_force load_force force_amplitude",
        "elements": "mesh n_elements resolution nodes",
        "probes": "probe",
        "initial_overlap": "dents initial_dents dent",
        "law": "contact_law model contact_model",
        "name": "title label",
    }.items()
    for word in words.split()
}
_WITHIN = {
    "packing.shape": "size",
    "load.force": "amplitude",
    "load.time": "duration",
    "load.length": "duration",
    "load.period": "frequency",
}
_NOTES = {
    "restitution": "take contact.loss = {restitution = 0.9, velocity = 1.0}; without it the contact law decides",
    "gravity": 'take [precompression] with kind = "gravity" and, perhaps, acceleration',
    "damping": "contacts dissipate by yielding (contact.law), contact.friction and contact.loss = {dashpot = 0.1}",
    "ranks": "the number of MPI ranks is given on the command line: --np",
}
_OTHER_WORDS = {
    "restitution": "cor e_n coefficient_of_restitution",
    "gravity": "g gravitation gravity_acceleration",
    "damping": "viscosity dashpot gamma gamma_n",
    "ranks": "np threads cores processors",
}
_NOTES |= {word: _NOTES[known] for known, words in _OTHER_WORDS.items() for word in words.split()}


def hint_for(name: str, known: Collection[str], prefix: str, vocabulary: Sequence[str] = ()) -> str:
    """Suggest the key that an unknown one was probably meant to be.

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
    elsewhere = _elsewhere([word], vocabulary) or (_elsewhere([meant], vocabulary) if meant else [])
    if not elsewhere:
        elsewhere = _elsewhere(difflib.get_close_matches(word, _last_parts(vocabulary), cutoff=_SIMILAR), vocabulary)
    if elsewhere:
        there = [f"{key}, outside [{prefix}]" if prefix and "." not in key else key for key in elsewhere]
        return f"did you mean {' or '.join(there[:_MOST])}?"
    faint = difflib.get_close_matches(word, known, n=1, cutoff=_FAINT)
    return f"did you mean {faint[0]}?" if faint else "known here: " + ", ".join(known)


def _elsewhere(words: Iterable[str], vocabulary: Sequence[str]) -> list[str]:
    """Return the dotted keys that end in one of the words; numbered tables only if no other table has them."""
    found = [key for word in words for key in vocabulary if key.rpartition(".")[2] == word]
    return [key for key in found if not any(part.isdigit() for part in key.split("."))] or found


def _last_parts(vocabulary: Sequence[str]) -> list[str]:
    return list(dict.fromkeys(key.rpartition(".")[2] for key in vocabulary))
