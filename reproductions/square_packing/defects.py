"""Wave speed with defects.

The wave speed grows as a power of the force, which is 1/6 for identical spheres. The source quotes
1/4 for packings with defects and little precompression, from other work on hexagonal packings,
without tolerance or load. Our first runs are small waves in precompressed packings, where contact
forces are proportional to the pressure. The others are impacts on a square packing whose spheres of
scattered diameters stay at their sites, with gaps (peak contact forces of spheres 6 to 10 of a
central chain, means over seeds). Local powers are between two neighbouring loads.
"""

import numpy as np
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import power_law, pulse_peaks, speed_along_layers
from granwave.theory import precompressed_line

# spheres between which the speed is measured, counted from the impacted sphere as 1
FIRST = 6
LAST = 10
BACKGROUND = {"where": "square packing, 2-D Background"}
FCC = "fcc under pressure"
SQUARE = "square packing, in-plane impact"


def under_pressure(run):
    """Pressure (Pa), and speed of small waves (m/s)."""
    return run.case.precompression.pressure, speed_along_layers(
        run.result, precompressed_line(run.case)
    )


def struck(run):
    """Peak force (N) and speed (m/s) of the wave in a central chain."""
    case = run.case
    first = run.case.striker[0].touches[0]
    ids = np.arange(first, first + case.packing.size[0])
    velocity = run.fields.velocity.sel(id=ids, axis="x").to_numpy()
    when = pulse_peaks(run.fields.time.to_numpy(), velocity, case.packing.diameter).time
    forces = run.contacts.set_index(["i", "j"]).peak_force
    force = np.mean([forces[one, one + 1] for one in ids[FIRST - 1 : LAST]])
    return force, (LAST - FIRST) * case.packing.diameter / (when[LAST - 1] - when[FIRST - 1])


def measured(runs):
    """Loads (Pa or N) and speeds (m/s) in rising order, by packing and tolerance (m), means over
    seeds.
    """
    found = {}
    for run in runs:
        fcc = run.case.packing.kind == "fcc"
        case = run.case
        key = FCC if fcc else SQUARE, case.packing.diameter_scatter
        load = case.precompression.pressure if fcc else case.striker[1].velocity
        found.setdefault(key, {}).setdefault(load, []).append(
            under_pressure(run) if fcc else struck(run)
        )
    means = {
        key: [np.mean(seeds, axis=0).tolist() for seeds in found[key].values()]
        for key in sorted(found)
    }
    return {key: np.transpose(sorted(points)) for key, points in means.items()}


def label(packing, scatter):
    return f"{packing}, " + (f"scatter {1e6 * scatter:g} µm" if scatter else "identical spheres")


def rows(runs):
    for (packing, scatter), (load, speed) in measured(runs).items():
        name = label(packing, scatter)
        unit = "Pa" if packing == FCC else "N"
        loads = f"{load[0]:.3g} to {load[-1]:.3g} {unit}"
        quantity = f"Exponent of the wave speed against the force, {name}, {loads}"
        whole = power_law(load, speed).exponent
        local = np.diff(np.log(speed)) / np.diff(np.log(load))
        # fmt: off
        if not scatter:
            yield gw.Row(quantity, ours=whole, theory=1 / 6, verification=packing == SQUARE, **BACKGROUND,
                         remark=("Every correct elastic code gives this value, because of "
                                 "similarity."))
        else:
            yield gw.Row(quantity, source=0.25, ours=whole, **BACKGROUND,
                         remark=f"There is no single power: it changes from {local[0]:.3f} at the "
                                f"lowest loads to {local[-1]:.3f} at the highest. The source "
                                "quotes the value from other work, for hexagonal packings with "
                                "little precompression. According to it defects make waves faster; "
                                "here they make them slower, in particular weak waves.")
            yield gw.Row(f"The same at the lowest loads, {name}", ours=local[0], **BACKGROUND)
            yield gw.Row(f"The same at the highest loads, {name}", ours=local[-1], theory=1 / 6, **BACKGROUND)
        # fmt: on


def pictures(runs):
    found = measured(runs)
    for packing, name, quantity, unit in (
        (FCC, "_pressure", "the static pressure", "Pressure (Pa)"),
        (SQUARE, "_force", "the peak force of the wave", "Peak force (N)"),
    ):
        shown = {key: pair for key, pair in found.items() if key[0] == packing}
        if not shown:
            continue
        figure = Figure((3.5, 3.2), layout="constrained")
        axes = figure.subplots()
        data = {}
        for (key, (load, speed)), mark in zip(shown.items(), "os", strict=False):
            axes.loglog(load, speed, f"{mark}-", markersize=3.5, label=label(*key))
            data |= {
                f"scatter_{1e6 * key[1]:g}_um_load": load,
                f"scatter_{1e6 * key[1]:g}_um_speed_m_s": speed,
            }
        for power, line, text in ((1 / 6, ":k", "1/6"), (1 / 4, "--k", "1/4")):
            axes.loglog(load, speed[-1] * (load / load[-1]) ** power, line, label=text)
        axes.set(xlabel=unit, ylabel="Wave speed (m/s)")
        figure.legend(loc="outside upper center", ncols=2, fontsize=7)
        caption = (
            f"Wave speed against {quantity}, with powers of 1/6 (identical spheres) and 1/4 "
            "(source). "
        )
        caption += (
            "Scattered diameters leave gaps, which slow weak waves most; the curve is "
            "therefore steepest on the left"
        )
        yield gw.Picture(name, caption, figure, data)
