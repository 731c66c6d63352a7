"""Damping in the contacts of composite chains.

Composite chains have Hertz's law and Tsuji's dashpot in every contact. The dashpot is given by the
restitution of a collision, which does not depend on the speed. V and lambda are defined as in the
study of composite chains. The source gives no restitution; the value used here is typical of
polished metal spheres.
"""

from matplotlib.figure import Figure
from section import SPEEDS, STRESSES, WATCHED, by, sections

import granwave as gw


def restitution(section):
    return section.case.contact.loss.dashpot.restitution


def series(runs):
    """Chains by material of the section and falling restitution, by rising length."""
    found = sorted(sections(runs), key=lambda section: (section.light, -restitution(section)))
    return by(found, lambda section: (section.light, restitution(section)))


def rows(runs):
    where = "composite chain, "
    for (light, value), chains in series(runs).items():
        kind, speeds, (begin, end) = (
            f"{light}, restitution {value:g}",
            SPEEDS[light],
            STRESSES[light],
        )
        first = chains[0]
        last = chains[-1]
        # fmt: off
        for chain in chains[:: max(len(chains) - 1, 1)]:
            remark = ("The source value was measured. The restitution is our choice. The study "
                      "of the measured speeds lists the possible reasons for the difference "
                      "that were tested.")
            yield gw.Row(f"V, N2 = {chain.n}, {kind}", "m/s", speeds.get(chain.n), chain.speed, f"{where}section 4, measured",
                         remark if chain.n in speeds else "")
        if len(chains) > 1:
            yield gw.Row(f"Change of V from N2 = {first.n} to {last.n}, {kind}", "%",
                         100 * (speeds[last.n] / speeds[first.n] - 1) if speeds else None,
                         100 * (last.speed / first.speed - 1), f"{where}section 4, measured",
                         "The source value follows from its two values of V." if speeds else "")
            yield gw.Row(f"Change of lambda from N2 = {first.n} to {last.n}, {kind}", "%",
                         ours=100 * (last.ratio / first.ratio - 1), where=f"{where}Fig. 11",
                         remark=f"lambda changes from {first.ratio:.3f} to {last.ratio:.3f}. In "
                                "the source lambda falls exponentially.")
        for chain in (one for one in chains if one.n == WATCHED):
            name = ("Largest pressure of the last contact / first contact of the section, N2 = "
                    f"{chain.n}, "
                    f"{kind}")
            yield gw.Row(name, "", end / begin, chain.pressure(chain.last - 1) / chain.pressure(chain.first),
                         f"{where}3.3", "The source value is the ratio of its two compressive "
                                        "stresses, without N2.")
        # fmt: on


def pictures(runs):
    figure = Figure((7, 3), layout="constrained")
    data = {}
    colours = {}
    left, right = figure.subplots(1, 2)
    for (light, value), chains in series(runs).items():
        mark = "os"[light in colours]
        colour = colours.setdefault(light, f"C{len(colours)}")
        name = f"{light}_restitution_{value:g}".replace("-", "_").replace(".", "_")
        n, speed, ratio = zip(*((one.n, one.speed, one.ratio) for one in chains), strict=True)
        left.plot(
            n,
            speed,
            f"{mark}-",
            color=colour,
            markersize=4,
            label=f"{light}, restitution {value:g}",
        )
        right.plot(n, ratio, f"{mark}-", color=colour, markersize=4)
        data |= {f"{name}_n": n, f"{name}_speed_m_s": speed, f"{name}_ratio": ratio}
    for light, speeds in SPEEDS.items():
        if light in colours and speeds:
            left.plot(
                *zip(*speeds.items(), strict=True),
                "x",
                color=colours[light],
                label=f"{light}, measured",
            )
    left.set(xlabel="Beads in the section $N_2$", ylabel="Speed $V$ (m/s)")
    right.set(xlabel="Beads in the section $N_2$", ylabel=r"$\lambda$")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    caption = (
        "Speed V and lambda, output / incident peak, against the length of the section, by "
        "restitution of the contacts. Damping affects lambda far more than V, which varies as the "
        "sixth root of the force"
    )
    yield gw.Picture("composite_loss", caption, figure, data)


def verdict(runs):
    for (light, value), chains in series(runs).items():
        (first, *_, last), speeds = chains, SPEEDS[light]
        measured = (
            f" (measured: {100 * (1 - speeds[last.n] / speeds[first.n]):.2g} %)" if speeds else ""
        )
        if value < 1:
            yield (
                f"With restitution {value:g} lambda falls from {first.ratio:.3f} ({first.n} beads of {light}) to "
                f"{last.ratio:.3f} ({last.n}), and V by {100 * (1 - last.speed / first.speed):.2g} %{measured}."
            )
