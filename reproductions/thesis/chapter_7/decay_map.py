"""Filter: decay against diameter and length of the cylinders (thesis Figs 7.2 and 7.3).

The impact is on sphere 20 of chains of 160 spheres, at 1 m/s. Walls just touch the cylinders, or
press them. gamma and eta are the diameter and the length of the cylinders, and a the approach of
the walls, all divided by the diameter of the spheres. The decay is the slope of ln(peak force)
between contacts 61 and 111.
"""

import dataclasses

import numpy as np
from filter_row import KILO, FilterRow
from matplotlib.figure import Figure

import granwave as gw

FIT = (61, 111)  # contacts
LEAST = 100  # points of a map
PRESSED = 8e-4  # approach of the walls, a
COLOURS_END = {0.0: 7.0, PRESSED: 9.0}  # 1e-3 a contact, of Fig. 7.2
RATIO = 10.0  # end of the colours of Fig. 7.3
LOW_GAMMA = 0.6  # largest gamma of the bands, which the source stays below
STEP = 0.5  # step of the colours of a decay, 1e-3
MARKS = 5  # marks of the colours of the ratio, on either side


@dataclasses.dataclass(frozen=True)
class Maps:
    """Decay per contact, 1e-3, by gamma and eta: an array (gammas, etas) for each approach."""

    gammas: np.ndarray
    etas: np.ndarray
    decay: dict[float, np.ndarray]

    @property
    def low(self):
        """Gammas of the bands, an array of booleans."""
        return self.gammas <= LOW_GAMMA

    @property
    def ratio(self):
        """Ratio of the decay with pressing walls to the decay with touching walls."""
        return self.decay[PRESSED] / self.decay[0.0]

    def square(self, a):
        """Decay of the cylinders with the length of the spheres, by gamma."""
        return self.decay[a][:, np.argmin(abs(self.etas - 1.0))]

    def misfit_of_mass(self, a):
        """Return the rms difference between the decay of a cylinder with low gamma and the decay of
        the cylinder with eta = 1 and the same mass, divided by the rms deviation of these decays
        from their mean.
        """
        mass = self.gammas[:, None] ** 2 * self.etas
        alike = np.interp(mass, self.gammas**2, self.square(a))
        inside = self.low[:, None] & (mass >= self.gammas[0] ** 2)
        misfit = np.std(self.decay[a][inside] - alike[inside])
        return misfit / np.std(self.decay[a][inside])


def select(runs):
    """Maps of both approaches; empty for a single scan, which has only one approach."""
    rows = [FilterRow(run) for run in runs]
    gammas = np.unique([row.gamma for row in rows])
    etas = np.unique([row.eta for row in rows])
    maps = {a: np.full((len(gammas), len(etas)), np.nan) for a in COLOURS_END}
    for row in rows:
        place = np.searchsorted(gammas, row.gamma), np.searchsorted(etas, row.eta)
        if row.a in maps:
            maps[row.a][place] = KILO * row.decay(*FIT)
    whole = all(np.isfinite(decay).all() for decay in maps.values())
    is_map = len(gammas) * len(etas) >= LEAST
    return [Maps(gammas, etas, maps)] if whole and is_map else []


def rows(maps):
    for a, end in COLOURS_END.items():
        within = maps.decay[a][maps.low]
        whole = maps.decay[a].max()
        yield gw.Row(
            f"Largest decay per contact, gamma up to {LOW_GAMMA:g}, a = {a:g}, at most", "1e-3", end,
            within.max(), "thesis Fig. 7.2", "The bound is the end of the colour scale. The "
                                             f"largest decay of the whole map is {whole:.3g}.",
            digits=3, bound=True,
        )  # fmt: skip
        reach = np.ptp(maps.square(a)[maps.low]) / np.ptp(within)
        yield gw.Row(
            f"Range of decays at eta = 1 / range of the map, gamma <= {LOW_GAMMA:g}, a = {a:g}",
            source=1.0, ours=reach, where="thesis 7.1",
            remark="According to the source every decay of the map occurs for some diameter at "
                   "eta = 1.",
            digits=2,
        )  # fmt: skip
        yield gw.Row(
            f"Decay by the mass of the cylinder: misfit, gamma <= {LOW_GAMMA:g}, a = {a:g}",
            ours=maps.misfit_of_mass(a), where="thesis Fig. 7.2",
            remark="The misfit is 0 if the bands are lines of equal mass, and 1 if the decay does "
                   "not depend on the mass.",
            digits=2,
        )  # fmt: skip
    beyond = np.mean(abs(maps.ratio) > RATIO)
    yield gw.Row(
        f"Fraction of the map with a ratio of the decays beyond {RATIO:g}", ours=beyond,
        where="thesis Fig. 7.3", digits=2,
        remark="The limits are the ends of the colour scale. With touching walls the wave hardly "
               "decays there.",
    )  # fmt: skip


def pictures(maps):
    figure = Figure((7, 2.8), layout="constrained")
    panels = figure.subplots(1, len(maps.decay) + 1, sharey=True)
    for axes, (a, decay) in zip(panels, maps.decay.items(), strict=False):
        levels = np.arange(0.0, COLOURS_END[a] + STEP / 2, STEP)
        drawn = axes.contourf(maps.gammas, maps.etas, decay.T, levels, extend="both")
        marks = np.arange(COLOURS_END[a] + 1)
        figure.colorbar(drawn, ax=axes, label="Decay per contact (1e-3)", ticks=marks)
        axes.set(title=f"a = {a:g}")
    levels = np.linspace(-RATIO, RATIO, 2 * MARKS + 1)
    drawn = panels[-1].contourf(
        maps.gammas, maps.etas, maps.ratio.T, levels, cmap="RdBu_r", extend="both"
    )
    figure.colorbar(drawn, ax=panels[-1], label="Ratio of the decays")
    panels[-1].set(title="pressed / touching")
    for axes in panels:
        axes.set(xlabel=r"$\gamma$")
    panels[0].set(ylabel=r"$\eta$")
    gammas, etas = np.meshgrid(maps.gammas, maps.etas, indexing="ij")
    data = {"gamma": gammas.ravel(), "eta": etas.ravel()}
    data |= {
        f"decay_{'pressed' if a else 'touching'}": 1e-3 * decay.ravel()
        for a, decay in maps.decay.items()
    }
    caption = (
        "Decay of the peak force per contact against diameter (gamma) and length (eta) of the "
    )
    caption += "cylinders, and its "
    caption += "ratio: the maps of thesis Figs 7.2 and 7.3, with the same axes and colours"
    yield gw.Picture("filter_map", caption, figure, data)
