"""Small tables for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.planning.wall_time import WallTime
from granwave.workflows.solvers import Cost

_SUMMARY = {
    "n_spheres": ("spheres", "{:d}"),
    "n_contacts": ("touching at the start", "{:d}"),
    "end_time_s": ("simulated", "{:.6g} s"),
    "end_reason": ("ended", "{}"),
    "timestep_s": ("timestep", "{:.4g} s"),
    "n_steps": ("steps", "{:d}"),
    "energy_input_J": ("energy in", "{:.6g} J"),
    "dissipated_fraction": ("dissipated", "{:.5f} of it"),
    "plastic_fraction": ("  by yielding", "{:.5f} of it"),
    "friction_fraction": ("  by friction", "{:.5f} of it"),
    "energy_balance_error": ("balance error", "{:.1e} of it"),
    "peak_force_N": ("peak contact force", "{:.6g} N"),
    "n_plastic_contacts": ("yielded contacts", "{:d}"),
    "n_plastic_spheres": ("plastic spheres", "{:d}"),
    "plastic_zone_depth_m": ("plastic zone depth", "{:.4g} m"),
    "plastic_zone_radius_m": ("plastic zone radius", "{:.4g} m"),
    "wave_speed_m_s": ("wave speed", "{:.4g} m/s"),
    "contacts_beyond_law": ("contacts beyond 0.2 R*", "{:d}"),
    "wall_peak_force_N": ("peak force at the bottom", "{:.6g} N"),
    "wall_impulse_Ns": ("impulse at the bottom", "{:.6g} N s"),
    "peak_reduction": ("peak without packing", "{:.3g} times as high"),
    "impactor_velocity_m_s": ("struck sphere at the end", "{:.5g} m/s"),
    "wall_time_s": ("wall time", "{:.1f} s"),
    "sphere_steps_per_s": ("speed", "{:.3g} sphere-steps/s"),
}


def lines(rows: list[tuple[str, str]]) -> str:
    """Labels and values under each other."""
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in rows)


def summary_table(summary: Mapping[str, Any]) -> str:
    """The main values of a summary."""
    left_out = () if summary.get("friction_fraction") else ("plastic_fraction", "friction_fraction")
    rows = [
        (label, form.format(summary[key]))
        for key, (label, form) in _SUMMARY.items()
        if summary.get(key) is not None and key not in left_out
    ]
    return lines([("case", str(summary["name"])), *rows])


_CONTINUUM = {
    "n_elements": ("elements", "{:d}"),
    "end_time_s": ("simulated", "{:.4g} s"),
    "end_reason": ("ended", "{}"),
    "n_steps": ("steps", "{:d}"),
    "energy_input_J": ("energy in", "{:.6g} J"),
    "energy_input_normalised": ("normalised", "{:.4g} sigma_y^2 D^3/E"),
    "dissipated_fraction": ("dissipated", "{:.5f} of it, plastically"),
    "energy_balance_error": ("balance error", "{:.1e} of it"),
    "plastic_zone_volume_m3": ("plastic zone", "{:.4g} m3 at one instant"),
    "plastic_zone_volume_ever_m3": ("", "{:.4g} m3 that ever yielded"),
    "plastic_zone_depth_m": ("its depth", "{:.4g} m"),
    "plastic_zone_radius_m": ("its radius", "{:.4g} m"),
    "max_overlap_m": ("largest overlap", "{:.4g} m"),
    "max_force_N": ("force there", "{:.5g} N"),
    "contact_radius_m": ("contact radius", "{:.4g} m"),
    "force_deviation_max_percent": ("force less the law", "{:+.1f} % at most"),
    "force_deviation_rms_percent": ("", "{:.1f} % rms"),
    "unloading_exponent_min": ("unloading exponents", "from {:.2f}"),
    "unloading_exponent_max": ("", "to {:.2f}"),
    "kinetic_share_max": ("kinetic energy", "{:.1e} of the internal, at most"),
    "wall_time_s": ("wall time", "{:.1f} s"),
    "element_steps_per_s": ("speed", "{:.3g} element-steps/s"),
}


def continuum_table(summary: Mapping[str, Any]) -> str:
    """The main values of the summary of a continuum run."""
    return lines(
        [("case", str(summary["name"]))]
        + [
            (label, form.format(summary[key]))
            for key, (label, form) in _CONTINUUM.items()
            if summary.get(key) is not None
        ]
    )


def plan_table(case: Case, plan: Plan) -> str:
    """What a run would be."""
    schedule, times = plan.schedule, plan.times
    usual, most = duration(times.total), duration(times.longest)
    at_most = "at most " if schedule.block_steps else ""
    overlap = f"{plan.peak_overlap:.3g} m, {plan.peak_overlap_radius:.3g} R*"
    if plan.peak_overlap_yield is not None:
        overlap += f", {plan.peak_overlap_yield:.3g} of that at first yield"
    if case.contact.entry.fitted and plan.peak_overlap_radius > 0.2:
        overlap += " - beyond 0.2 R*, where the contact law ends"
    return lines(
        [
            ("case", plan.name),
            ("spheres", f"{plan.n_spheres}"),
            ("touching at the start", f"{plan.n_contacts}"),
            ("memory", f"about {plan.memory / 2**30:.2f} GiB"),
            ("disk", f"about {plan.disk / 1e9:.3g} GB"),
            ("timestep", f"{schedule.timestep:.4g} s"),
            ("steps", f"{at_most}{schedule.n_steps}, to {schedule.end_time:.4g} s"),
            ("snapshots", f"{at_most}{schedule.n_frames}"),
            ("expected time", f"about {usual}: {_parts(times)}"),
            *([("", f"at most {most}")] if schedule.block_steps and most != usual else []),
            *([("static stage", static_words([times]))] if times.most_static > times.static else []),
            ("largest overlap", f"up to {overlap}"),
        ]
    )


def _parts(times: WallTime) -> str:
    """Which parts the time of a run has."""
    parts = {
        "static stage": times.static,
        "steps": times.steps,
        "set-up and analysis": times.rest,
        "figures": times.figures,
    }
    return ", ".join(f"{name} {duration(time)}" for name, time in parts.items() if time >= 0.5)


def static_words(times: Sequence[WallTime], jobs: float = 1.0) -> str:
    """What a plan says of static stages whose length cannot be known, with so many jobs at once."""
    counted, most = sum(time.static for time in times) / jobs, sum(time.most_static for time in times) / jobs
    return f"counted with {duration(counted)}, but cannot be known where there is disorder: up to {duration(most)}"


def continuum_plan_table(name: str, n_elements: int, cost: Cost) -> str:
    """What a continuum run would be."""
    return lines(
        [
            ("case", name),
            ("elements", f"about {n_elements}"),
            ("memory", f"about {cost.memory / 2**30:.2f} GiB"),
            ("disk", f"about {cost.disk / 1e9:.3g} GB"),
            ("expected time", f"about {duration(cost.wall_time)}"),
        ]
    )
