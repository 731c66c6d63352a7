"""A packing that is hit again and again

The dents of the first impact stay in the contacts, and with them the packing has hardened: the second impact loses
less, and more force reaches the bottom. Each run takes its dents from the directory of the one before.
"""

from granwave.analysis.figures.style import BLUE, ORANGE, new_figure, style
from granwave.workflows import load_case, run_case

HITS = 5
lost, passed = [], []
for hit in range(1, HITS + 1):
    changes = {"packing.size": [10, 10, 6], "run.end_time": 4e-4}
    if hit > 1:
        changes["contact.initial_overlap"] = f"hit-{hit - 1}"
    outcome = run_case(load_case("fcc-small", changes), f"hit-{hit}", force=True, figures=False)
    lost.append(outcome.summary["dissipated_fraction"])
    passed.append(outcome.summary["wall_peak_force_N"])
    print(f"hit {hit}: {lost[-1]:.3f} of the energy dissipated, {passed[-1]:.0f} N at the bottom")

with style():
    figure = new_figure(2.4, width=5.6)
    left, right = figure.subplots(1, 2)
    left.plot(range(1, HITS + 1), lost, "o-", color=BLUE, markersize=4)
    left.set(xlabel="hit", ylabel="share dissipated", ylim=(0, 1))
    right.plot(range(1, HITS + 1), passed, "o-", color=ORANGE, markersize=4)
    right.set(xlabel="hit", ylabel="peak force at the bottom (N)", ylim=(0, None))
    figure.savefig("picture.png", dpi=150)
