"""Elastic bar.

A half-sine and a rectangular force pulse act on the end of a bar with 25 to 400 elements per metre;
they are compared with the closed forms of a slender bar. Sections lie at a quarter and at three
quarters of the length, and only signals before the first echo count. If the whole pulse has passed
both sections, its speed is the speed of its centroid; otherwise it is the speed of the rise through
half the largest force. Kinks of the pulse, as at the ends of a half-sine, limit the error of the
shape to the power 2/3 of the element size. The edges of a rectangle are shorter than any element
and cause ripples on every mesh. Speed, impedance and energy converge nevertheless.
"""

import numpy as np
from bar_pulse import Passage, closed_forms
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import power_law

EDGE = "An edge is shorter than any element and therefore ripples and overshoots."


def measured(runs):
    """Passages by the shape of the pulse, the finest mesh first."""
    found = {"half-sine": [], "rectangle": []}
    for run in sorted(runs, key=lambda run: -run.case.incident_bar.elements):
        found[run.case.load.shape].append(Passage(run, "incident_bar"))
    return found


def rows(runs):
    found = measured(runs)
    for (shape, meshes), edge in zip(found.items(), ("", EDGE), strict=True):
        yield from closed_forms(meshes[0], f"bar-pulse, {shape} incident bar", edge)
    pitch, error = np.array([(one.pitch, one.deviation) for one in found["half-sine"]]).T
    yield gw.Row(
        "Order of the error of the shape in the element size, half-sine", ours=power_law(pitch, error).exponent,
        theory=2 / 3, where="thesis 3.2.1", verification=True,
        remark=f"The power is fitted to {len(pitch)} meshes. Kinks at the ends of the pulse limit "
               "it to 2/3.",
    )  # fmt: skip


def pictures(runs):
    found = measured(runs)
    one = found["half-sine"][0]
    axes = Figure((3.4, 2.4), layout="constrained").subplots()
    axes.plot(1e6 * one.time, 1e-3 * one.entered(one.time), "0.5", label="entered")
    data = {"time_s": one.time, "entered_N": one.entered(one.time)}
    for n, x in enumerate(one.sections):
        axes.plot(1e6 * one.time, 1e-3 * one.force[n], f"C{n}", label=f"at {x:.3g} m")
        axes.plot(
            1e6 * one.time,
            1e-3 * one.late(n),
            "k:",
            linewidth=0.8,
            label="closed form" if n else None,
        )
        data |= {f"at_{x:.4g}_m_N": one.force[n], f"closed_form_at_{x:.4g}_m_N": one.late(n)}
    axes.set(
        xlabel="Time (µs)",
        ylabel="Section force (kN)",
        xlim=(0, 1e6 * one.time[-1]),
        ylim=(None, 15),
    )
    axes.legend(ncols=2)
    caption = (
        "Force against time in an elastic bar: the incoming pulse, and the pulse at two sections. "
        "In the closed form of a slender bar the same pulse arrives later; the curves deviate "
        "from it only by the error of the elements"
    )
    yield gw.Picture("bar_pulse", caption, axes.figure, data)
    figure = Figure((6.8, 2.7), layout="constrained")
    data = {}
    for axes, (shape, meshes) in zip(
        figure.subplots(1, 2, sharey=True), found.items(), strict=True
    ):
        pitch = np.array([one.pitch for one in meshes])
        data[f"{shape}: element_m"] = pitch
        errors = {
            "speed": [abs(one.speed / one.c - 1) for one in meshes],
            "impedance": [abs(one.measured_impedance / one.impedance - 1) for one in meshes],
            "shape": [one.deviation for one in meshes],
            "energy": [abs(one.energy - 1) for one in meshes],
        }
        for (what, values), mark in zip(errors.items(), "os^D", strict=True):
            axes.plot(1e3 * pitch, values, marker=mark, markersize=4, label=what)
            data[f"{shape}: error_of_{what}"] = values
        for order, line, name in ((2 / 3, "--", "order 2/3"), (2, ":", "order 2")):
            axes.plot(
                1e3 * pitch, 0.2 * (pitch / pitch.max()) ** order, line, color="0.5", label=name
            )
        axes.set(xlabel="Element (mm)", xscale="log", yscale="log", title=shape)
        axes.set_xticks(1e3 * pitch, [f"{1e3 * one:.3g}" for one in pitch])
        axes.set_xticks([], minor=True)
    figure.axes[0].set(ylabel="Error relative to the closed form", ylim=(1e-7, 2))
    axes.legend(fontsize=7, loc="lower left", ncols=2)
    caption = (
        "Errors of an elastic bar against the size of its elements, by the shape of the pulse. "
        "Speed, impedance and energy converge for both; the shape converges with order 2/3 for "
        "kinks, and not at all for steps"
    )
    yield gw.Picture("bar_convergence", caption, figure, data)
