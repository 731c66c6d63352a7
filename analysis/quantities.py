"""The quantities of ``summary.json``, each once: its name there, in reports and at the terminal,
and where it is shown.

A new value is an entry of ``ENTRIES``; its name is added to the lists below that show it.
It is computed in `granwave.analysis.summary`. Entries of extensions state where they are shown, see
`Extension`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Container
from fnmatch import fnmatchcase
from functools import cache
from itertools import chain, product
from typing import Any

from granwave.lammps_inputs.extensions import added

SHARES = (
    50,
    90,
    99,
)  # percentages of the plastic dissipation for which sizes of the plastic zone are computed

#: Unit by the end of a name; the first match counts.
UNITS = {
    "_m_s2": "m/s^2", "_m_s": "m/s", "_N_per_m": "N/m", "_Hz": "Hz", "_per_kg": "1/kg",
    "_per_m": "1/m", "_per_s": "1/s", "_kg": "kg", "_m3": "m^3",
    "_Ns": "N s", "_Pa": "Pa", "_J": "J", "_W": "W", "_N": "N", "_s": "s", "_m": "m",
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A value of ``summary.json``; omitted fields follow from its name."""

    name: str  # key; families of keys have * in place of the part that differs
    label: str = ""  # name in reports; by default the words of the key
    meaning: str = ""  # a sentence for reports, where the label is not sufficient
    # name at the terminal, which consecutive rows may share; by default the label
    short: str = ""
    digits: str = ""  # format of the number at the terminal; empty for counts and words
    phrase: str = ""  # words around the number at the terminal; by default the unit follows
    axis: str = ""  # title of an axis in figures of scans, without the unit
    symbol: str = ""  # LaTeX symbol for the axis
    note: str = ""  # a sentence for the reference, for values whose label is sufficient in a report
    # for extensions: value of REPORT_COLUMNS that it follows in reports; empty: not in reports
    after: str = ""
    # for extensions: whether it has a column at the end of a scan; beginning of the names of its
    # figures
    scan_column: bool = False
    scan_figure: str = ""

    def __post_init__(self) -> None:
        """Fill in omitted values."""
        ending = next((ending for ending in UNITS if self.name.endswith(ending)), "")
        label = self.label or readable(self.name.removesuffix(ending))
        short = self.short or label[:1].lower() + label[1:]
        phrase = self.phrase or f"{{}} {self.unit.replace('^', '')}".rstrip()
        for name, value in (("label", label), ("short", short), ("phrase", phrase)):
            object.__setattr__(self, name, value)

    @property
    def unit(self) -> str:
        """Unit at the end of the name, such as ``m/s^2``; empty if there is none."""
        return next((unit for ending, unit in UNITS.items() if self.name.endswith(ending)), "")

    @property
    def title(self) -> str:
        """Title of an axis, without the unit."""
        return f"{self.axis} ${self.symbol}$" if self.symbol else self.axis

    @property
    def heading(self) -> str:
        """Head of a column at the terminal."""
        return f"{self.short} ({self.unit.replace('^', '')})" if self.unit else self.short

    def text(self, value: Any) -> str:
        """A value at the terminal."""
        return self.phrase.format(format(value, self.digits))


_PERSON = "von Mises"  # keeps its capital, and its small letter at the beginning


def readable(name: str) -> str:
    """A file's or key's name as words."""
    words = name.replace("_", " ").strip().replace(_PERSON.lower(), _PERSON)
    if words.startswith(_PERSON):
        return words
    return words[:1].upper() + words[1:]


_OUTERMOST = (
    "Position of the outermost yielded sphere (element), independently of the energy that it "
    "dissipated."
)
_HOLDS_90 = {
    "depth": "Smallest depth below the centre of the impacted sphere (the face of the block) "
    "that contains 90 % of the plastic dissipation, evaluated at the centres of "
    "spheres (elements) without interpolation: in a lattice it is the depth of a "
    "layer. Strikers are excluded. The 50 % and 99 % values are defined in the same "
    "way.",
    "radius": "Smallest distance from the impact axis that contains 90 % of the plastic "
    "dissipation, "
    "evaluated like the depth. The axis is parallel to z through the centroid of the impacted "
    "spheres.",
    "volume": "Smallest volume that contains 90 % of the plastic dissipation: spheres (elements) "
    "are added in descending order of energy per volume. The voids between spheres and the "
    "strikers are excluded.",
}
_INTERPOLATED_90 = {
    "depth": "The 90 % depth, interpolated linearly in the energy between layers; at most the "
    "depth of the layer. It changes continuously with the dissipation, but in a lattice with few "
    "layers or shells a small change of the dissipation can move it by the distance of two of "
    "them.",
    "radius": "The 90 % radius, interpolated like the depth.",
}


def _zone_sizes() -> tuple[Quantity, ...]:
    """Sizes of the plastic zone."""
    whole = product((("depth", "m", "z"), ("radius", "m", "r"), ("volume", "m3", "V")), SHARES)
    between = product((("depth", "z"), ("radius", "r")), SHARES)
    return tuple(
        Quantity(
            f"zone_{size}_{share}_{unit}",
            f"Plastic zone, {share} % {size}",
            short=f"{share} % {size}",
            digits=".4g",
            meaning=_HOLDS_90[size] if share == 90 else "",
            note="" if share == 90 else f"Same definition as zone_{size}_90_{unit}.",
            axis=f"{share} % {size}",
            symbol=f"{symbol}_{{{share}}}",
        )
        for (size, unit, symbol), share in whole
    ) + tuple(
        Quantity(
            f"zone_{size}_{share}_interpolated_m",
            f"Plastic zone, {share} % {size}, interpolated",
            short=f"{share} % {size}",
            digits=".4g",
            meaning=_INTERPOLATED_90[size] if share == 90 else "",
            note="" if share == 90 else f"Same definition as zone_{size}_90_interpolated_m.",
            axis=f"{share} % {size}, interpolated",
            symbol=f"{symbol}_{{{share}}}",
        )
        for (size, symbol), share in between
    )


#: Entries of the core by group, in the order of the reference page.
GROUPS: dict[str, tuple[Quantity, ...]] = {
    "Size and run": (
    Quantity("name", note="Name of the case."),
    Quantity("n_spheres", "Spheres", note="Number of grains, including strikers and cylinders."),
    Quantity("n_cylinders", "Cylinders among the grains", short="cylinders",
             note="Only for packings with cylinders."),
    Quantity("n_clumps", "Clumps",
             note="Groups of grains that move as one rigid body; only for packings with clumps."),
    Quantity("n_contacts", "Contacts at the start",
             "Pairs of spheres that touch before the run; smaller spheres at lattice sites leave "
             "gaps."),
    Quantity("n_loaded_contacts", "Loaded contacts",
             "Pairs of spheres that carried a force at some time during the run. The overlap "
             "must exceed 1e-6 of the yield overlap, which excludes rounding errors; for "
             "elastic contacts any overlap is counted."),
    Quantity("n_wall_contacts", "Wall contacts", note="Number of sphere-wall pairs in result.h5."),
    Quantity("end_time_s", short="simulated", digits=".6g", note="Time at the end of the run."),
    Quantity("end_reason", short="ended",
             note="Reason for the end of the run, such as end_time or settled."),
    Quantity("incomplete_values", "Values that the end of the run limits",
             "Fractions of the input energy and numbers of yielded contacts that still grow in the "
             "last tenth of the run, and forces on the bottom of which a larger one may follow."),
    Quantity("timestep_s", digits=".4g",
             meaning="Simulated time divided by the number of steps; the mean of an automatic "
             "timestep."),
    Quantity("timestep_smallest_s", "Smallest timestep", digits=".4g",
             note="Smallest timestep of the run."),
    Quantity("timestep_largest_s", "Largest timestep", digits=".4g",
             note="Largest timestep of the run."),
    Quantity("n_steps", "Steps", note="Number of steps of the run."),
    Quantity("wall_time_s", digits=".1f", note="Wall time of the time integration."),
    Quantity("sphere_steps_per_s", short="speed", digits=".3g", phrase="{} sphere-steps/s",
             note="Spheres times steps, divided by wall time."),
    Quantity("n_ranks", "MPI ranks", note="Number of MPI ranks of the run."),
    Quantity("versions", note="Versions of the programs on which the result depends."),
    ),
    "Energies": (
    Quantity("energy_input_J", "Energy input", short="energy in", digits=".6g",
             note="Kinetic energy of the impactor, or work of a force or a moved end up to the end "
             "of the run."),
    Quantity("energy_input_normalised", "Energy input, normalised", short="normalised",
             digits=".4g", phrase="{} sigma_y^2 D^3/E", axis="Input energy",
             symbol=r"e_\mathrm{in}/(F_\mathrm{y}\alpha_\mathrm{y})",
             note="Packings: relative to F_y alpha_y of two spheres. Continuum: relative to "
                  "sigma_y^2 D^3/E with the diameter of the punch. The values of packing and "
                  "continuum cannot be compared."),
    Quantity("velocity_normalised", "Velocity, normalised", axis="Normalised impact velocity",
             symbol=r"\bar{v}_0",
             note="(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v, with which results "
                  "for different materials fall on one curve."),
    Quantity("dissipated_fraction", short="dissipated", digits=".5f", phrase="{} of the input",
             axis="Dissipated fraction", symbol=r"e_\mathrm{dis}/e_\mathrm{in}",
             note="Dissipated energy relative to the energy input."),
    Quantity("plastic_fraction", "Fraction dissipated by yielding",
             "Energy dissipated by yielding of contacts in this run, relative to the energy "
             "input.", short="  by yielding", digits=".5f", phrase="{} of the input"),
    Quantity("friction_fraction", "Fraction dissipated by friction",
             "Energy dissipated by sliding between spheres and at walls, relative to the energy "
             "input.", short="  by friction", digits=".5f", phrase="{} of the input"),
    Quantity("viscous_fraction", "Fraction dissipated by viscous damping",
             "Energy dissipated by viscous damping of contacts (contact.loss), including walls, "
             "relative to the energy input.", short="  by viscous damping", digits=".5f",
             phrase="{} of the input", axis="Viscous dissipation / input"),
    Quantity("rolling_fraction", "Fraction dissipated by resistance to rolling",
             "Energy dissipated by contact.rolling, including walls, relative to the energy input; "
             "only if contacts have it.", short="  by rolling", digits=".5f",
             phrase="{} of the input"),
    Quantity("twisting_fraction", "Fraction dissipated by resistance to twisting",
             "Energy dissipated by contact.twisting, including walls, relative to the energy "
             "input; only if contacts have it.", short="  by twisting", digits=".5f",
             phrase="{} of the input"),
    Quantity("adhesion_fraction", "Fraction dissipated by cohesion",
             "Energy dissipated when cohesive surfaces snap into contact and separate (JKR), "
             "including walls, relative to the energy input; only with cohesion.",
             short="  by cohesion", digits=".5f", phrase="{} of the input"),
    Quantity("holder_fraction", "Fraction dissipated by friction in the guide",
             "Energy dissipated by beads of a chain that slide in their guide, relative to the "
             "energy input.", short="  in the guide", digits=".5f", phrase="{} of the input"),
    Quantity("absorbed_fraction", "Fraction absorbed by the sponge layer",
             "Energy absorbed by the spheres of [[absorb]], relative to the energy input.",
             short="  absorbed", digits=".5f", phrase="{} of the input"),
    Quantity("transmission", "Transmission",
             "Velocity of the last bead before the absorbing beads, divided by the velocity of the "
             "loaded bead: amplitudes at the frequency of a harmonic load, over the last whole "
             "periods; null if the motion is not steady within 2 %.", digits=".4g",
             axis="Transmission"),
    Quantity("driven_velocity_m_s", "Velocity of the loaded sphere",
             "Amplitude of this velocity at the frequency of a harmonic load.", digits=".4g"),
    Quantity("load_power_W", "Power of the load",
             "Mean power over the last half of a run under a harmonic load.", digits=".4g"),
    Quantity("absorbed_power_W", "Power absorbed",
             "Mean power absorbed by the spheres of [[absorb]] and the damper below, in the last "
             "half of a run under a harmonic load; null without these.", digits=".4g"),
    Quantity("amplitude_hysteresis", "Hysteresis of amplitude",
             "Largest difference of the last bead's velocity between rising and falling amplitude "
             "of a load, relative to its largest value; 0 if the chain has a single state at every "
             "amplitude.", digits=".2g"),
    Quantity("unsteady_part", "Unsteady part",
             "Fraction of the motion at frequencies other than the load frequency and its second "
             "and third harmonics, of the loaded or last bead, whichever is larger.", digits=".2g"),
    Quantity("deck_changed", "Input files changed by hand",
             "Values in case.toml may differ from the values of the run.",
             short="deck changed by hand"),
    Quantity("energy_balance_error", "Balance error", digits=".1e", phrase="{} of the input",
             note="Largest value of |kinetic + elastic + dissipated - input| at any time, relative "
             "to the largest input up to the end; with a prescribed displacement, without the "
             "kinetic energy of the moved grains."),
    Quantity("energy_balance_accepted", "Accepted balance error",
             note="Largest balance error with which this run is accepted; a run with a larger "
             "error is rejected."),
    Quantity("energy_kinetic_J", "Kinetic energy", note="Kinetic energy at the end. Packings: "
             "including rotation and the impactor. Continuum: of the block only, without the punch "
             "(energy_punch_J). The values of packing and continuum cannot be compared."),
    Quantity("energy_rotational_J", "Kinetic energy of rotation", "Part of the kinetic energy."),
    Quantity("energy_elastic_J", "Elastic energy",
             note="Recoverable energy of contacts, springs and bars at the end."),
    Quantity("energy_dissipated_J", "Dissipated energy",
             note="Energy dissipated up to the end by yielding, friction, viscous damping and "
                  "dampers."),
    Quantity("energy_dissipated_wall_J", "Dissipated at walls",
             note="Part of the dissipated energy."),
    Quantity("energy_dissipated_plastic_J", "Dissipated by yielding",
             note="Part of the dissipated energy."),
    Quantity("energy_dissipated_friction_J", "Dissipated by friction",
             note="Part of the dissipated energy."),
    Quantity("energy_dissipated_rolling_J", "Dissipated by resistance to rolling",
             note="Part of the dissipated energy."),
    Quantity("energy_dissipated_twisting_J", "Dissipated by resistance to twisting",
             note="Part of the dissipated energy."),
    Quantity("energy_dissipated_adhesion_J", "Dissipated by cohesion",
             note=("Part of the dissipated energy, dissipated when surfaces snap into contact "
                   "and separate.")),
    Quantity("energy_dissipated_viscous_J", "Dissipated by viscous damping",
             note="Part of the dissipated energy; null without contact.loss."),
    Quantity("energy_dissipated_holder_J", "Dissipated by friction in the guide",
             note="Part of the dissipated energy."),
    Quantity("energy_absorbed_J", "Absorbed by absorbing spheres",
             note="Part of the dissipated energy."),
    Quantity("energy_bar_J", "Energy of the bar", note="Kinetic and elastic energy at the end."),
    Quantity("energy_incident_bar_J", "Energy of the incident bar",
             note="Kinetic and elastic energy at the end."),
    ),
    "Contacts": (
    Quantity("peak_force_N", "Peak contact force, excluding walls",
             "Largest force of all contacts between two spheres at any time; in the continuum, the "
             "largest force on the punch, as means between records, which are at most 0.2 µs "
             "apart.", short="peak force, excluding walls", digits=".6g",
             axis="Peak force between spheres", symbol=r"F_\mathrm{max}"),
    Quantity("peak_force_with_walls_N", "Peak contact force, including walls",
             "Largest force of all contacts at any time, including contacts with walls, plates and "
             "bars.",
             short="peak force, with walls", digits=".6g", axis="Peak force, including walls",
             symbol=r"F_\mathrm{max}"),
    Quantity("peak_force_error_N", "Error bar of the peak contact force", digits=".2g",
             meaning="Largest deviation of the contact law from finite elements, as given by law "
             "elastoplastic-fe for the contact with the peak force.",
             note="Error of the law at this overlap, not of the run; null for other laws, outside "
             "the range of the fit, with cohesion and with a rate-dependent yield strength."),
    Quantity("peak_overlap_m",
             note="Largest overlap of two spheres at any time, excluding walls; null if no two "
             "spheres are in contact."),
    Quantity("contacts_beyond_law", "Contacts beyond the law", short="contacts beyond 0.2 R*",
             note="Contacts whose overlap exceeded 0.2 R*, the limit of the fit of the law."),
    Quantity("contacts_beyond_half_law", "Contacts beyond half the range of the law",
             note="Contacts whose overlap exceeded 0.1 R*."),
    ),
    "Plastic zone": (
    Quantity("n_plastic_contacts", "Yielded contacts",
             "Contacts between two spheres whose overlap exceeded first yield in this run; an "
             "earlier indentation counts only if it grew. Just beyond first yield, a contact "
             "can keep an indentation without having dissipated energy."),
    Quantity("n_dissipating_contacts", "Yielded contacts that dissipated energy",
             "Yielded contacts that dissipated energy by yielding.", short="  that dissipated"),
    Quantity("n_plastic_spheres", "Yielded spheres", axis="Yielded spheres", symbol=r"N_\mathrm{p}",
             meaning="Spheres with a yielded contact; contacts with walls are not counted."),
    Quantity("n_dissipating_spheres", "Spheres that dissipated energy",
             "Spheres that dissipated energy by any mechanism, including contacts with walls; the "
             "number in the figures of "
             "dissipation. Excludes spheres whose contacts yielded without dissipating energy.",
             short="dissipating spheres"),
    Quantity("plastic_zone_volume_m3", "Plastic zone volume",
             "Volume of all spheres that yielded at contacts with spheres; in the continuum, "
             "the largest yielding volume at one instant. The values of packing and continuum "
             "cannot be compared.", short="plastic zone", digits=".4g",
             phrase="{} m3 at one instant", axis="Plastic zone", symbol=r"V_\mathrm{p}"),
    Quantity("plastic_zone_depth_m", "Plastic zone, depth", _OUTERMOST, digits=".4g",
             axis="Depth of the plastic zone", symbol=r"z_\mathrm{p}"),
    Quantity("plastic_zone_radius_m", "Plastic zone, radius", _OUTERMOST, digits=".4g"),
    *_zone_sizes(),
    Quantity("zone_cut", "Boundaries reached by the plastic zone",
             "Boundaries that a yielded sphere (element) touches, which limit the zone.",
             short="zone reaches"),
    Quantity("sides_periodic", "Periodic sides",
             "The packing continues periodically across its sides; sides in zone_cut and "
             "wave_returned then mean the periodic images of the impact."),
    Quantity("zone_growing", "Plastic zone still growing at the end",
             "The outermost sphere in depth or radius yielded in the last tenth of the run."),
    Quantity("wave_returned", "Boundaries with returned reflections",
             "Boundaries whose reflected wave can reach the 99 % zone before the end of the run."),
    Quantity("wave_return_s", "Earliest return of a reflection",
             "Estimated from the first force peaks at the boundary and at the zone; in the "
             "continuum, from the speed of compression waves."),
    Quantity("wave_return_share", "Fraction dissipated after reflections arrived",
             "Upper limit of the fraction of plastic dissipation that is due to reflections."),
    ),
    "Static stage": (
    Quantity("energy_stored_J", "Energy stored by precompression",
             "Elastic energy of the contacts after the static stage, the reference of the energies "
             "of the run."),
    Quantity("precompression_residual", "Residual of the static stage",
             "Largest net force on a sphere after the static stage, relative to the largest "
             "contact force."),
    ),
    "Bottom and target": (
    Quantity("wall_peak_force_N", "Peak force on the bottom", short="peak force at the bottom",
             digits=".6g", axis="Peak force on the bottom",
             meaning="Largest force of the packing on the bottom, including the static force. "
                     "For a single contact it is the largest value of all steps, otherwise of "
                     "the records, which have the interval wall_sample_s."),
    Quantity("wall_dynamic_peak_force_N", "Peak dynamic force on the bottom",
             "Largest increase of the force on the bottom above its value before the load; 0 if "
             "the wave has not arrived. Only for packings with a static force.",
             short="dynamic part", digits=".6g"),
    Quantity("wall_sample_s", "Interval of records of the force on the bottom",
             note="Longest time between two records; absent where a single contact carries the "
             "force, whose largest value is exact."),
    Quantity("wall_impulse_Ns", "Impulse on the bottom", short="impulse at the bottom",
             digits=".6g",
             meaning="Integral of the force on the bottom up to the end, including the static "
             "force."),
    Quantity("wall_dynamic_impulse_Ns", "Dynamic impulse on the bottom",
             "Integral, up to the end, of the change of the force on the bottom since before the "
             "load. Only where there is a static force.",
             short="dynamic part of the impulse", digits=".6g"),
    Quantity("wall_*_peak_force_N", "Peak force on a side wall",
             "Largest force on each wall, including the static force, by name: xlo, xhi, ylo, yhi "
             "or tube."),
    Quantity("wall_*_impulse_Ns", "Impulse on a side wall",
             "Integral of the force on the wall over the run, including the static force."),
    Quantity("plate_peak_force_N", "Peak force on the plate",
             "Force of all grains on a rigid plate.", digits=".6g"),
    Quantity("plate_impulse_Ns", "Impulse on the plate", "Integral of the force on the plate over "
                                                         "the run.",
             digits=".6g"),
    Quantity("plate_velocity_m_s", "Plate velocity at the end",
             "Velocity of the plate into the packing; negative after a rebound.", digits=".5g",
             axis="Velocity of the plate at the end", symbol=r"v_\mathrm{p}"),
    Quantity("energy_plate_J", "Kinetic energy of the plate", "Part of the kinetic energy."),
    Quantity("base_arrival_s", "Arrival at the bottom",
             "Arrival time of the wave at the bottom: first time at which the force on the "
             "bottom has increased by 1 % of its largest increase in the run, interpolated between "
             "records. Null if the force still increases at the end, because the largest increase "
             "is then not known."),
    Quantity("target_peak_force_N", "Peak force on the target",
             "Force on the bottom, which the packing protects."),
    Quantity("target_peak_displacement_m", "Largest displacement of the target",
             note="Largest outward displacement from the position before the impact."),
    Quantity("energy_target_J", "Work on the target",
             "Work of the packing on the bottom up to the end; zero for a fixed bottom."),
    Quantity("support_energy_J", "Energy in the support",
             "Kinetic and elastic energy of the support of the bottom; part of the elastic "
             "energy."),
    Quantity("support_lost_J", "Energy absorbed by the damper of the support",
             "Energy absorbed by the damper, or by the non-reflecting end of a bar; part of the "
             "dissipated energy."),
    Quantity("ground_peak_force_N", "Peak force on the ground",
             "Force of the last spring or damper of the bottom; for a bottom at rest, the force on "
             "the bottom."),
    Quantity("unprotected_peak_force_N", "Peak force without the packing",
             "Peak force of the same impact directly on the bottom, without the packing."),
    Quantity("unprotected_ground_peak_force_N", "Peak force on the ground without the packing",
             note="Peak force on the ground of the same impact directly on the bottom."),
    Quantity("peak_reduction", "Peak reduction",
             "Peak force on the bottom without the packing, divided by the peak dynamic force with "
             "it, which excludes the static force before the load; null for oscillating loads.",
             short="peak force without / with packing", digits=".3g",
             axis="Peak force without / with packing"),
    Quantity("ground_peak_reduction", "Peak reduction on the ground",
             "Peak force on the ground without the packing, divided by the peak dynamic force with "
             "it."),
    Quantity("peak_reduction_per_kg", "Peak reduction per mass of packing",
             note="Peak reduction divided by the mass of the packing."),
    Quantity("peak_reduction_per_m", "Peak reduction per height of packing",
             note="Peak reduction divided by the height of the packing."),
    Quantity("packing_mass_kg", "Mass of the packing"),
    Quantity("packing_height_m", "Height of the packing"),
    ),
    "Motion": (
    Quantity("wave_speed_m_s", "Wave speed in the deeper half", short="wave speed", digits=".4g",
             phrase="{} m/s in the deeper half", axis="Wave speed", symbol="c",
             note="Speed of the wave front in the deeper half of the layers that the wave reached "
                  "in the run, for any materials. The front reaches a bead of a chain when the "
                  "force first exceeds 10 % of its first pulse, a contact of a packing when the "
                  "force first exceeds 10 % of its largest value. Requires at least nine layers. "
                  "Null for parallel cylinders."),
    Quantity("impactor_velocity_m_s", "Impacted sphere or striker at the end",
             short="sphere or striker at the end", digits=".5g",
             note="Velocity along the impact or load.direction; negative after a rebound. With "
                  "strikers, the velocity of the moving striker."),
    Quantity("restitution", digits=".5g", axis="Coefficient of restitution", symbol="e",
             meaning="Coefficient of restitution: relative normal velocity of the two bodies "
             "after the impact divided by the relative normal velocity before it.",
             note="Given for a single sphere on a rigid wall, and for the impact of two spheres."),
    Quantity("restitution_error", "Error bar of the restitution", digits=".2g",
             meaning="Largest deviation of the coefficient of restitution from finite elements, as "
             "given by law elastoplastic-fe.",
             note="Null if peak_force_error_N is null, and with contact.loss."),
    Quantity("sensor_*_peak_force_N",
             note="Only for chains: largest mean of the two contact forces of the bead."),
    Quantity("sensor_*_peak_acceleration_m_s2", note="Only for packings other than chains."),
    Quantity("sensor_*_peak_velocity_m_s", note="Only for packings other than chains."),
    ),
    "Lines of grains": (
    Quantity("line_*_front_speed_m_s", "Front speed along a line",
             "Slope of the distance against the arrival time, which is the time at which the speed "
             "of a grain first reaches 5 % of the speed of the load."),
    Quantity("line_*_peak_first_m_s", "First peak along a line",
             "Peak speed: the first maximum above 5 % of the speed of the load, followed by a "
             "decrease of at least 10 %."),
    Quantity("line_*_peak_last_m_s", "Last peak along a line",
             "Velocity of the first peak at the last grain that the wave reached."),
    Quantity("line_*_decay_first_per_m", "Decay along a line, first region",
             "Decay of the peak speed, from a continuous broken line fitted to its logarithm; "
             "excludes grains near a fixed floor."),
    Quantity("line_*_decay_second_per_m", "Decay along a line, second region",
             "Decay of the peak speed beyond the border between the two regions."),
    Quantity("line_*_decay_border_m", "Border of the regions, along the line",
             "Distance from the first grain of the line."),
    Quantity("line_*_decay_per_m", "Decay along a line, one region",
             "Decay from a single exponential through the same peaks."),
    Quantity("line_*_largest_speed_mean_m_s", "Largest speeds of a line, mean",
             "Mean over the grains of the line, for the whole run."),
    Quantity("line_*_largest_speed_deviation_m_s", "Largest speeds of a line, standard deviation",
             "Standard deviation with n - 1 in the denominator."),
    Quantity("line_*_largest_speed_skewness", "Largest speeds of a line, skewness",
             "Skewness, corrected for the sample size."),
    Quantity("line_*_largest_speed_normal_p", "Largest speeds of a line, p of normality",
             "Result of the Shapiro-Wilk test; small values reject a normal distribution."),
    ),
}  # fmt: skip

ENTRIES = tuple(chain.from_iterable(GROUPS.values()))

_OF_THE_CORE = {entry.name: entry for entry in ENTRIES}


@cache
def entries() -> tuple[Quantity, ...]:
    """Return the entries of all values, with extensions after `ENTRIES`."""
    found = list(ENTRIES)
    for more in added("quantities"):
        found += more
    return tuple(found)


@cache
def quantities() -> dict[str, Quantity]:
    """Return the entries of all values by name; the core takes precedence."""
    return {entry.name: entry for entry in reversed(entries())}


@cache
def quantity(name: str) -> Quantity:
    """Entry of a value of a summary; without an entry, as from other programs, it follows from the
    name.
    """
    if name in quantities():
        return quantities()[name]
    families = (entry for entry in entries() if "*" in entry.name)
    family = next((entry for entry in families if fnmatchcase(name, entry.name)), Quantity(name))
    return dataclasses.replace(family, name=name, label="", short="")


def _changed(name: str, **changes: Any) -> Quantity:
    """An entry with a different label in one table."""
    return dataclasses.replace(_OF_THE_CORE[name], **changes)


def _quantities(*names: str | Quantity) -> tuple[Quantity, ...]:
    return tuple(_OF_THE_CORE[name] if isinstance(name, str) else name for name in names)


#: Columns of the tables of results in reports, see `report_columns`.
REPORT_COLUMNS = (
    "restitution", "dissipated_fraction", "plastic_fraction", "friction_fraction",
    "rolling_fraction", "twisting_fraction",
    "adhesion_fraction", "viscous_fraction", "holder_fraction",
    "absorbed_fraction", "transmission", "load_power_W", "absorbed_power_W",
    "peak_force_N", "peak_force_with_walls_N", "n_plastic_contacts", "n_dissipating_contacts",
    "n_plastic_spheres", "n_dissipating_spheres", "plastic_zone_volume_m3", "plastic_zone_depth_m",
    "plastic_zone_radius_m", "zone_depth_90_m", "zone_depth_90_interpolated_m",
    "zone_radius_90_m", "zone_radius_90_interpolated_m", "zone_volume_90_m3", "zone_cut",
    "wave_return_share", "wall_peak_force_N", "wall_dynamic_peak_force_N", "wall_impulse_Ns",
    "wall_dynamic_impulse_Ns", "base_arrival_s", "unprotected_peak_force_N",
    "peak_reduction", "ground_peak_force_N", "target_peak_displacement_m", "energy_target_J", "impactor_velocity_m_s",
    "wave_speed_m_s", "energy_input_J", "energy_input_normalised", "velocity_normalised", "contacts_beyond_law",
    "energy_balance_error", "deck_changed", "n_spheres", "end_time_s", "wall_time_s",
)  # fmt: skip


@cache
def report_columns() -> tuple[str, ...]:
    """Return the columns of the tables of results in reports, if they have values; values of
    extensions follow the entry ``after``.
    """
    columns = list(REPORT_COLUMNS)
    for entry in entries():
        if entry.after in columns:
            columns.insert(columns.index(entry.after) + 1, entry.name)
    return tuple(columns)


#: Shown only where there is friction.
FRICTION_SHARES = ("plastic_fraction", "friction_fraction")

#: Rows at the terminal at the end of a run.
RUN_ROWS = _quantities(
    "n_spheres", "n_cylinders", "n_clumps",
    "n_contacts", "n_loaded_contacts", "end_time_s", "end_reason", "timestep_s",
    "n_steps", "energy_input_J", "dissipated_fraction", *FRICTION_SHARES, "rolling_fraction", "twisting_fraction",
    "adhesion_fraction", "viscous_fraction", "holder_fraction",
    "absorbed_fraction",
    "energy_balance_error", "peak_force_N", "peak_force_with_walls_N",
    "n_plastic_contacts", "n_dissipating_contacts", "n_plastic_spheres", "n_dissipating_spheres", "plastic_zone_depth_m", "plastic_zone_radius_m", "wave_speed_m_s",
    "contacts_beyond_law", "wall_peak_force_N", "wall_dynamic_peak_force_N", "wall_impulse_Ns",
    "wall_dynamic_impulse_Ns", "peak_reduction", "impactor_velocity_m_s", "restitution",
    "transmission", "load_power_W", "absorbed_power_W", "wall_time_s", "sphere_steps_per_s",
)  # fmt: skip

#: Columns at the terminal at the end of a scan, see `scan_columns`.
SCAN_COLUMNS = _quantities(
    _changed("restitution", digits=".5f"), "transmission", "dissipated_fraction",
    "n_plastic_spheres", "plastic_zone_volume_m3", "zone_depth_90_interpolated_m", "zone_volume_90_m3",
    "zone_cut", _changed("peak_force_N", short="peak force, no walls", digits=".5g"),
    _changed("peak_force_with_walls_N", short="with walls", digits=".5g"),
)  # fmt: skip


@cache
def scan_columns() -> tuple[Quantity, ...]:
    """Return the columns at the end of a scan: numbers, with the unit in the head."""
    return (*SCAN_COLUMNS, *(entry for entry in entries() if entry.scan_column))


#: Quantities in figures of scans, with the beginnings of the names of the figures, see
#: `scan_figures`.
SCAN_FIGURES = {
    "peak_reduction": "peak_reduction", "restitution": "restitution",
    "transmission": "transmission", "dissipated_fraction": "dissipated_fraction",
    "plastic_zone_depth": "plastic_zone_depth_m", "zone_depth_90": "zone_depth_90_interpolated_m",
    "zone_radius_90": "zone_radius_90_interpolated_m", "zone_volume_90": "zone_volume_90_m3",
    "plastic_zone_volume": "plastic_zone_volume_m3", "plastic_spheres": "n_plastic_spheres",
    "peak_force": "peak_force_N", "bottom_peak_force": "wall_peak_force_N", "wave_speed": "wave_speed_m_s",
}  # fmt: skip

#: Values that figures show in place of one of `SCAN_FIGURES` that a scan lacks: that of results of
#: 1.0 and earlier, and the force at walls where points have no contact between spheres.
_IN_PLACE = {
    "peak_force_N": "peak_force_with_walls_N",
    "zone_depth_90_interpolated_m": "zone_depth_90_m",
    "zone_radius_90_interpolated_m": "zone_radius_90_m",
}


@cache
def all_scan_figures() -> dict[str, str]:
    """Return the quantities that figures of scans show, by the beginnings of figure names."""
    return SCAN_FIGURES | {
        entry.scan_figure: entry.name for entry in entries() if entry.scan_figure
    }


#: Sizes of the plastic zone that change by whole layers, with the sizes interpolated between
#: layers, which sentences and short tables give.
SIZES_BY_LAYERS = {
    "zone_depth_90_m": "zone_depth_90_interpolated_m",
    "zone_radius_90_m": "zone_radius_90_interpolated_m",
}


def scan_figures(there: Container[str]) -> dict[str, str]:
    """Return the quantities of figures of a scan by the names of figures, of a scan whose summaries
    have the values ``there``.
    """
    return {
        name: _IN_PLACE[key] if key not in there and _IN_PLACE.get(key) in there else key
        for name, key in all_scan_figures().items()
    }
