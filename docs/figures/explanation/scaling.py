"""Share of the time in which ranks work on their spheres, by the model of a step."""

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
from page_figures import save

from granwave.lammps_inputs.load_case import load_assembly
from granwave.lammps_inputs.planning.ranks import ROUGH, StepCosts, best_grid, mean_times, wave_of
from granwave.workflows import library

RANKS = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 10_000]
SURFACE = StepCosts(rest=0.0, active=0.0, moving=0.0, ghost=1.0, message=0.0, total=0.0)
SIZE = [232, 232, 186]  # 10 million spheres

assembly = load_assembly(library.find("fcc-impact"), {"packing.size": SIZE})
local = wave_of(assembly)
layer = np.array([local.high[0], local.high[1], local.last[2]])
plane = dataclasses.replace(local, first=local.low, last=layer)

figure, both = plt.subplots(1, 2, figsize=(7, 2.8), sharey=True, layout="constrained")
for axes, wave, title in zip(
    both, (local, plane), ("local impact", "whole top layer"), strict=True
):
    for style, label in (("o--", "smallest surface"), ("s-", 'processors = "auto"')):
        costs = SURFACE if style == "o--" else ROUGH
        chosen = [best_grid(wave, n, costs) for n in RANKS]
        times = [mean_times(wave, grid, ROUGH) for grid in chosen]
        axes.semilogx(RANKS, [time.efficiency for time in times], style, label=label)
    axes.set(title=title, xlabel="ranks", ylim=(0, 1))
both[0].set_ylabel("efficiency")
both[0].legend()
save(both[0], "efficiency")
