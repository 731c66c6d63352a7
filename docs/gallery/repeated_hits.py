"""A packing that is hit again and again

The dents of the first impact stay in the contacts, and with them the packing has hardened: the second impact loses
less, and more force reaches the bottom. Each run takes its dents from the directory of the one before. Beside it is
a packing that forgets dents during a hit, where the undeformed spheres part, and has all dents again before the next.
"""

from granwave.analysis.figures.style import BLUE, ORANGE, new_figure, style
from granwave.workflows import load_case, run_case

HITS = 5
GAPS = {"kept": 0.1, "forgotten": 1e-9}  # diameters: a dent is forgotten beyond this gap
lost, passed = {}, {}
for dents, gap in GAPS.items():
    lost[dents], passed[dents] = [], []
    for hit in range(1, HITS + 1):
        changes = {"packing.size": [10, 10, 6], "run.end_time": 4e-4, "boundary.forget_gap": gap}
        if hit > 1:
            changes["contact.initial_overlap"] = f"{dents}-{hit - 1}"
        outcome = run_case(load_case("fcc-small", changes), f"{dents}-{hit}", force=True, figures=False)
        lost[dents].append(outcome.summary["dissipated_fraction"])
        passed[dents].append(outcome.summary["wall_peak_force_N"])
        share, force = lost[dents][-1], passed[dents][-1]
        print(f"dents {dents}, hit {hit}: {share:.3f} of the energy dissipated, {force:.0f} N at the bottom")

with style():
    figure = new_figure(2.4, width=5.6)
    left, right = figure.subplots(1, 2)
    for (dents, shares), line, colour in zip(lost.items(), ("o-", "^--"), (BLUE, ORANGE), strict=True):
        left.plot(range(1, HITS + 1), shares, line, color=colour, markersize=4, label=f"dents {dents}")
        right.plot(range(1, HITS + 1), passed[dents], line, color=colour, markersize=4)
    left.set(xlabel="hit", ylabel="share dissipated", ylim=(0, 1))
    left.legend(loc="lower left")
    right.set(xlabel="hit", ylabel="peak force at the bottom (N)", ylim=(0, None))
    figure.savefig("picture.png", dpi=150)
