"""The wave of a struck elastic chain of like beads between two contacts, and its theory.

Two theories of the speed serve: Nesterenko's formula, of a continuum with the long-wave limit of the chain's
dispersion, and the travelling wave of the discrete chain itself (`discrete_speed`).
"""

from __future__ import annotations

from granwave.analysis.measures.chains.hertz_chain import IMPULSE_COEFFICIENT, discrete_speed
from granwave.analysis.measures.chains.record import ChainRecord


class StruckChain:
    """The wave between two contacts.

    Attributes
    ----------
    force, speed
        First peak at the second contact, N, and speed between both, m/s.
    expected
        Force of the impact by thesis 4.5, N.
    """

    def __init__(self, run: ChainRecord, contacts: tuple[int, int]) -> None:
        """Measure it.

        Parameters
        ----------
        contacts
            Numbers, from 0.
        """
        self.run, self.scales = run, run.scales
        (early, _), (late, self.force) = (run.first_peak(contact) for contact in contacts)
        self.speed = (contacts[1] - contacts[0]) * self.scales.diameter / (late - early)
        self.expected = IMPULSE_COEFFICIENT * self.scales.impulse_force(run.impulse)

    def wave(self, force: float) -> float:
        """Speed of the discrete chain's wave of this force, m/s."""
        return discrete_speed() * self.scales.nesterenko(force)

    def errors(self, force: float, speed: float) -> tuple[float, float]:
        """Errors of a force against the expected one, of a speed against that of the wave of this force; magnitudes."""
        return abs(force / self.expected - 1), abs(speed / self.wave(force) - 1)
