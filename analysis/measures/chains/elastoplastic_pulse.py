"""An elasto-plastic chain after a pulse, in the units of the chain (thesis 2.2)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.elastoplastic_model import SPACING
from granwave.analysis.measures.chains.line_pulse import LinePulse
from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.measures.hertz_chain import ChainScales
from granwave.analysis.measures.signals import Array


class PlasticWave(LinePulse):
    """One elasto-plastic chain after a pulse.

    Attributes
    ----------
    scales
        Units of the chain.
    impulse, duration
        Of the load, in units of E* R*^2 tau, and in tau.
    peak_unit, energy_unit
        E* R*^2 times that impulse, which peak forces are given in, N; F_y alpha_y, J.
    name
        The load in a few characters.
    """

    def __init__(self, run: ChainRecord) -> None:
        super().__init__(run.time, run.force, run.of_contacts("peak_force"))
        self.run, self.scales, load = run, ChainScales(run), run.load
        self.impulse, self.duration = run.impulse / self.scales.impulse, load.lasts / self.scales.time
        self.peak_unit, self.energy_unit = self.scales.force * self.impulse, run.law.yield_force * run.law.yield_overlap
        force = f"{load.largest / 1e3:g} kN, {load.lasts * 1e6:.3g} µs"
        self.name = f"{load.velocity:g} m/s" if load.kind == "impact" else force

    @property
    def place(self) -> Array:
        """Distance of the contacts from the struck end over R*: (contacts,)."""
        return SPACING * self.number

    @property
    def normalised(self) -> Array:
        """Largest force at each contact over E* R*^2 I: (contacts,)."""
        return self.largest / self.peak_unit

    def inverse_constant(self, first: int, last: int) -> float:
        """Mean of (x/R*) F / (E* R*^2 I) over contacts."""
        chosen = slice(first - 1, last)
        return float(np.mean(self.place[chosen] * self.normalised[chosen]))

    @property
    def speed_normalised(self) -> tuple[Array, Array]:
        """Distances over R*, and the speed of the leading disturbance there in R*/tau."""
        number, speed = self.speed
        return SPACING * number, SPACING * self.scales.time * speed

    @cached_property
    def dissipated(self) -> Array:
        """Up to each contact: (contacts,), J."""
        return np.cumsum(self.run.of_contacts("dissipated_energy"))[: self.contacts]
