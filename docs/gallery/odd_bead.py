"""An odd bead in a chain: where should it be?

Nineteen beads of brass and one of aluminium transmit a pulse of force to an elastic bar. How much energy arrives
depends on the place of the odd bead: near the struck end it helps, near the bar it hinders.
"""

from granwave.analysis.figures.style import BLUE, GREY, new_figure, style
from granwave.workflows import load_case, run_case

places = [1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 20]


def transmitted(material: str, place: int) -> float:
    """Return the energy in the bar at the end, J."""
    changes = {"replace.1.material": material, "replace.1.index": place, "output.history": 0}
    outcome = run_case(load_case("intruder", changes), "run", force=True, figures=False)
    return outcome.summary["energy_bar_J"]


energies = [transmitted("aluminium", place) for place in places]
brass = transmitted("brass", 1)

with style():
    figure = new_figure(2.6)
    axes = figure.subplots()
    axes.plot(places, energies, "o-", color=BLUE, markersize=3, label="aluminium among brass")
    axes.axhline(brass, color=GREY, linestyle="--", label="brass alone")
    axes.set(xlabel="place of the aluminium bead, from the struck end", ylabel="energy in the bar (J)")
    axes.legend()
    figure.savefig("picture.png", dpi=150)

by_energy = sorted(zip(energies, places, strict=True))
print(f"most  {by_energy[-1][0]:.3f} J, at place {by_energy[-1][1]}")
print(f"least {by_energy[0][0]:.3f} J, at place {by_energy[0][1]}")
print(f"brass {brass:.3f} J")
