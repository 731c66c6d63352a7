"""A packing that is hit again and again

The dents of the first impact stay in the contacts, and with them the packing has hardened: the second impact loses
less, and more force reaches the bottom. Each run takes its dents from the directory of the one before.
"""

import matplotlib.pyplot as plt

import granwave as gw

HITS = 5
lost, passed = [], []
for hit in range(1, HITS + 1):
    changes = {"packing.size": [10, 10, 6], "run.end_time": 4e-4}
    if hit > 1:
        changes["contact.initial_overlap"] = f"hit-{hit - 1}"
    run = gw.run("fcc-small", changes, directory=f"hit-{hit}", force=True)
    lost.append(run["dissipated_fraction"])
    passed.append(run["wall_peak_force_N"])
    print(f"hit {hit}: {lost[-1]:.3f} of the energy dissipated, {passed[-1]:.0f} N at the bottom")

with gw.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(5.6, 2.4))
    left.plot(range(1, HITS + 1), lost, "o-", color="C0", markersize=4)
    left.set(xlabel="hit", ylabel="share dissipated", ylim=(0, 1))
    right.plot(range(1, HITS + 1), passed, "o-", color="C1", markersize=4)
    right.set(xlabel="hit", ylabel="peak force at the bottom (N)", ylim=(0, None))
    figure.savefig("picture.png", dpi=150)
