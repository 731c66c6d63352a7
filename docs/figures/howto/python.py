"""A figure of a run with a line added, and a figure in the style of granwave."""

import matplotlib.pyplot as plt
from page_figures import save

import granwave as gw

run = gw.run("fcc-small", packing__size=[8, 8, 5], run__end_time=1e-4, directory="small")
force = run.figure("peak_force_depth")
force.axvline(20, color="grey", linewidth=0.5)
save(force, "peak_force_depth")
with gw.style():
    _, axes = plt.subplots()
    axes.plot(run.energies["kinetic"])
    axes.set(xlabel="Time (s)", ylabel="Kinetic energy (J)")
    save(axes, "kinetic")
