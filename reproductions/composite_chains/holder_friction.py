"""Friction of the holder in composite chains.

The beads of elastic composite chains lie in a horizontal guide. They press on the guide with their
weight and slide in it. V and lambda are defined as in the study of composite chains. Only friction
dissipates energy. In the source lambda falls with the length of the section; the source attributes
this to friction between beads and guide, without a coefficient.
"""

import numpy as np
from matplotlib.figure import Figure
from section import by, sections

import granwave as gw

GRAVITY = 9.81  # m/s^2


def friction_of(section):
    return section.case.boundary.holder_friction


def series(runs):
    """Chains by the section's material, by rising friction, by rising length."""
    return {light: by(sorted(alike, key=friction_of), friction_of)
            for light, alike in by(sections(runs), lambda section: section.light).items()}  # fmt: skip


def taken(section):
    """Coefficient of friction times weight and path, summed over all beads, from their recorded
    velocities, J.
    """
    paths = np.trapezoid(np.abs(section.chain.velocity), section.time, axis=0)
    masses = section.run.spheres.mass.loc[section.chain.array("chain/id")].to_numpy()
    return friction_of(section) * GRAVITY * (masses * paths).sum()


def rows(runs):
    for light, chains in series(runs).items():
        least, *others = chains
        for friction in others:
            for smooth, rough in list(zip(chains[least], chains[friction], strict=True))[
                :: len(chains[friction]) - 1
            ]:
                name = f"Change of lambda by friction {friction:g} instead of {least:g}, {light}, N2 = {rough.n}"
                remark = f"lambda is {rough.ratio:.4f}. V is {rough.speed:.1f} m/s, changed by "
                remark += f"{100 * (rough.speed / smooth.speed - 1):.2f} %."
                change = 100 * (rough.ratio / smooth.ratio - 1)
                yield gw.Row(
                    name, "%", ours=change, where="composite chain, section 4", remark=remark
                )
            name = f"Energy dissipated by the guide, friction {friction:g}, {light}, N2 = {rough.n}"
            yield gw.Row(name, "J", ours=rough.run.energies.holder.iloc[-1], theory=taken(rough), verification=True,
                         where="friction times weight times the path of every bead")  # fmt: skip


def pictures(runs):
    figure = Figure((7, 3), layout="constrained")
    data = {}
    panels = figure.subplots(1, 2)
    lost = 0.0
    for colour, (light, chains) in enumerate(series(runs).items()):
        smooth = next(iter(chains.values()))
        for mark, (friction, alike) in zip("os^", chains.items(), strict=False):
            name = f"{light}_{friction:g}".replace("-", "_").replace(".", "_")
            data[f"{name}_n"] = n = [one.n for one in alike]
            for axes, key, what in zip(
                panels, ("speed", "ratio"), ("speed_m_s", "ratio"), strict=True
            ):
                values, least = (
                    np.array([getattr(one, key) for one in found]) for found in (alike, smooth)
                )
                data[f"{name}_{what}"] = values
                lost = max(lost, *(1 - values / least)) if key == "ratio" else lost
                axes.plot(
                    n,
                    values / least,
                    f"{mark}-C{colour}",
                    ms=4,
                    label=f"{light}, friction {friction:g}",
                )
    for axes, what in zip(panels, ("Speed $V$", r"$\lambda$"), strict=True):
        axes.set(
            xlabel="Beads in the section $N_2$", ylabel=f"{what} / value at the smallest friction"
        )
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    caption = (
        "Speed and height of the output pulse, divided by their values at the least friction, "
        "against the length of the section. The difference from 1 is the effect of the guide: at "
        f"most {100 * lost:.2g} % of the height"
    )
    yield gw.Picture("composite_holder", caption, figure, data)


def verdict(runs):
    for light, chains in series(runs).items():
        smooth = chains[min(chains)][-1]
        rough = chains[max(chains)][-1]
        yield (
            f"Friction {max(chains):g} under the weight of the beads lowers the output pulse behind {rough.n} beads "
            f"of {light} by {100 * (1 - rough.ratio / smooth.ratio):.2g} %."
        )
