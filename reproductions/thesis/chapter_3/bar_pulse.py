"""A pulse that enters a slender elastic bar and passes two sections before any echo.

A pulse F(t) travels unchanged at c = sqrt(E/rho); the ratio of force to velocity is Z = A sqrt(E
rho), and the energy is the integral of F^2/Z. Two-node elements of length h with lumped masses
carry a wave number q at the frequency (2c/h) sin(qh/2) instead of cq, so that wavelengths that are
not long compared with h lag behind, and a front spreads over a length of (c t h^2/8)^(1/3) (Airy).
Hence the error of the shape falls with h^(2/3) where the pulse has a kink, as a half-sine has at
its ends, and not at all at a step, which overshoots by 27 %. The centroid moves at c on every mesh.
"""

import math

import numpy as np

import granwave as gw
from granwave.measures import arrival

SECTIONS = 0.25, 0.75  # lengths of the bar from the end where the pulse enters
AHEAD = 3.0  # widths of a front, by which it arrives early
THROUGH = 0.02  # fraction of its largest force below which a pulse has passed


class Passage:
    """The pulse in ``incident_bar`` (the load) or in ``bar`` (the contact force on the bar).

    Force (N) and velocity (m/s) at both sections are (2, n_times), NaN from the first echo on;
    ``energy`` is the energy in the bar at the end of the run divided by the energy of the pulse
    that entered.
    """

    def __init__(self, run, name):
        bar = getattr(run.case, name)
        result = run.result
        self.load = run.case.load
        place, force, velocity = (
            result[f"bars/{name}/{one}"] for one in ("position", "force", "velocity")
        )
        modulus = bar.material.youngs_modulus
        density = bar.material.density
        self.c = math.sqrt(modulus / density)
        self.impedance = bar.area * math.sqrt(modulus * density)
        self.pitch = bar.length / bar.elements
        self.time = result["chain/time"]
        self.driven = name == "incident_bar"
        if self.driven:
            instants = np.linspace(0, self.time[-1], 20 * len(self.time))
            self.contact = instants, self.load.at(instants)
        else:
            self.contact = result[f"walls/{name}/time"], result[f"walls/{name}/force"]
        self.peak = self.entered(self.time).max()
        instants, values = self.contact
        closed = np.trapezoid(values**2, instants) / self.impedance
        self.energy = run["energy_input_J" if self.driven else f"energy_{name}_J"] / closed
        depth = 0.5 * (place[1:] + place[:-1]) - place[0]
        elements = [np.abs(depth - share * bar.length).argmin() for share in SECTIONS]
        self.sections = depth[elements]
        start = instants[max(0, (values != 0).argmax() - 1)]
        reach = 2 * bar.length - AHEAD * (2 * bar.length * self.pitch**2 / 8) ** (1 / 3)
        clear = np.array([self.time < start + (reach - x) / self.c for x in self.sections])
        velocity = 0.5 * (velocity[:, 1:] + velocity[:, :-1])  # velocities of the elements
        self.force, self.velocity = (
            np.where(clear, one[:, elements].T, np.nan) for one in (force, velocity)
        )

    def entered(self, time):
        """Force at the end where the pulse enters, N."""
        return self.load.at(time) if self.driven else np.interp(time, *self.contact, left=0.0)

    def late(self, section):
        """The incoming pulse as it would pass a section of an ideal bar, N."""
        return self.entered(self.time - self.sections[section] / self.c)

    @property
    def speed(self):
        """Speed of the centroid of a pulse that passed both sections, otherwise of its rise through
        half its peak, m/s.
        """
        signals = [
            (self.time[np.isfinite(force)], force[np.isfinite(force)]) for force in self.force
        ]
        if all(abs(force[-1]) < THROUGH * self.peak for _, force in signals):
            near, far = (time @ force / force.sum() for time, force in signals)
        else:
            near, far = (arrival(time, force, 0.5 * self.peak) for time, force in signals)
        return (self.sections[1] - self.sections[0]) / (far - near)

    @property
    def measured_impedance(self):
        """Ratio of force to velocity at the far section, by least squares, N s/m."""
        force, velocity = (
            values[1][np.isfinite(self.force[1])] for values in (self.force, self.velocity)
        )
        return force @ velocity / (velocity @ velocity)

    @property
    def overshoot(self):
        """Largest force at the far section divided by the largest force at the entry."""
        return np.nanmax(self.force[1]) / self.peak

    @property
    def deviation(self):
        """Largest difference between the force at the far section and the pulse at the entry,
        delayed by x/c, divided by the peak of the pulse.
        """
        return np.nanmax(np.abs(self.force[1] - self.late(1))) / self.peak


def closed_forms(one, of, edge=""):
    """Rows of a pulse that passed both sections, with a remark on sharp edges."""
    of = f"{of} in elements of {1e3 * one.pitch:.3g} mm"
    lasts = f"There is no echo within the run of {1e6 * one.time[-1]:.4g} µs."
    # fmt: off
    for what, unit, ours, theory, remark in (
        ("Speed", "m/s", one.speed, one.c, lasts),
        ("Impedance", "N s/m", one.measured_impedance, one.impedance, ""),
        ("Peak at a section / incoming peak", "", one.overshoot, 1.0, edge),
        ("Largest deviation from the pulse's shape", "of its peak", one.deviation, 0.0, edge),
        ("Energy / integral of F²/Z", "", one.energy, 1.0, ""),
    ):
        yield gw.Row(f"{what}, {of}", unit, ours=ours, theory=theory, where="closed form", remark=remark,
                     verification=True)
    # fmt: on
