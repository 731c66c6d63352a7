"""Figure of a fit to coefficients of restitution."""

from __future__ import annotations

import numpy as np

from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import BLUE, GREY, Drawing
from granwave.extensions.continuum.law_fit.restitution_fit import RestitutionFit, restitution_at

_POINTS = 300
_MARGIN = 1.5  # factor by which curves extend beyond the slowest and the fastest impact


def rebound_drawing(fit: RestitutionFit) -> Drawing:
    """Draw the measured coefficients with both laws, and their deviations below."""
    rebounds = fit.rebounds
    velocity = rebounds.velocity
    measured = rebounds.restitution
    figure, above, below = panels(3.6, rows=2, sharex=True, height_ratios=(3, 2))
    above.semilogx(velocity, measured, "o", color="black", ms=3, mfc="none", label="measured")
    grid = np.geomspace(velocity.min() / _MARGIN, velocity.max() * _MARGIN, _POINTS)
    for law, colour, line, label in (
        (fit.published, GREY, "--", "before the fit"),
        (fit.law, BLUE, "-", "fit"),
    ):
        above.plot(grid, restitution_at(law, fit.mass, grid), line, color=colour, label=label)
    values = restitution_at(fit.law, fit.mass, velocity)
    before = restitution_at(fit.published, fit.mass, velocity)
    below.plot(velocity, values - measured, ".", color=BLUE)
    below.axhline(0, color="black", lw=0.5)
    above.set(ylabel="Coefficient of restitution", ylim=(0, 1.05))
    below.set(xlabel="Impact velocity (m/s)", ylabel="Fit minus measured")
    above.legend(loc="lower left")
    return Drawing(
        figure,
        {
            "velocity_m_s": velocity,
            "restitution": measured,
            "fit": values,
            "deviation": values - measured,
            "published": before,
            "published_deviation": before - measured,
        },
    )
