"""Contact law against finite elements.

Two elastic-perfectly-plastic spheres are pressed together by finite elements. Differences are the
force of the finite elements divided by the force of the contact law, minus 1, at equal overlap.
alpha_y is the overlap at first yield. The contact grows element by element, so that single values
have steps.
"""

import math
import tomllib

import h5py
import numpy as np

import granwave as gw

# alpha_y: overlap with the largest deviation of the law, and start of its plateau
SPOTS = 3.0, 10.0
DEEP = 0.19  # R*: nearly the end of Fig. 2.10, and of the law's fit
# mean pressures / yield strength: Thornton's, and the largest of the law
FIRST_YIELD = 16 / 15
PLATEAU = 2.48
SMOOTH = 0.02  # half-width of an average, in the logarithm of the overlap
REMARKS = (
    "The source states about 6 % at most. This range of overlaps is hardly visible in its Fig. "
    "2.8, which extends to 800 yield overlaps.",
    "According to the source, its law gives too large a force at large overlaps.",
)


class Contact:
    """Loading of two spheres: overlap divided by the overlap at first yield and by R*; force of the
    finite elements divided by the force of the law, minus 1.
    """

    def __init__(self, run):
        case = tomllib.loads((run.directory / "case.toml").read_text(encoding="utf-8"))
        partner = case.get("partner", {})
        material = case["material"]
        other = partner.get("material", case["material"])
        radii = sorted(
            one.get("radius", case["sphere"]["radius"]) for one in (case["sphere"], partner)
        )
        self.run = run
        self.like = material == other
        self.ratio = radii[1] / radii[0]
        self.strengths = [one.get("yield_strength", math.inf) for one in (material, other)]
        self.name = material["name"] if self.like else f"{material['name']} and {other['name']}"
        self.name += (
            f", radii {self.ratio:g} to 1"
            if self.ratio > 1
            else ", equal radii"
            if self.like
            else ""
        )
        with h5py.File(run.directory / "result.h5") as file:
            overlap, force, law, radius = (file[f"loading/{name}"][()]
                                           for name in ("overlap", "force", "law_force", "contact_radius"))  # fmt: skip
            self.pressures = [one["pressure"][()] for one in file["pressure"].values()]
            self.fields = {name: values[()] for name, values in file["fields"].items()}
        # area of Thornton's contact, over pi
        area = run["effective_radius_m"] * overlap
        self.scaled = overlap / run["yield_overlap_m"]
        self.depth = overlap / run["effective_radius_m"]
        self.over_law = force / law - 1
        self.area = radius**2 / area
        self.force = force / (FIRST_YIELD * min(self.strengths) * math.pi * area)

    def near(self, place, along, values):
        """Mean of the values near a point of one of the overlap scales."""
        return values[np.abs(np.log(along / place)) < SMOOTH].mean()

    @property
    def identical(self):
        """True for two spheres of one material and radius, as in the figures of 2.1.2."""
        return self.like and self.ratio == 1

    @property
    def share_of_softer(self):
        """Fraction of the plastic dissipation in the sphere with the smaller yield strength."""
        r, z = self.fields["position"][self.fields["elements"]].transpose(2, 0, 1)
        area = np.abs((r * np.roll(z, -1, 1) - z * np.roll(r, -1, 1)).sum(axis=1)) / 2
        strain = np.bincount(
            self.fields["body"], self.fields["plastic_strain"] * area * r.mean(axis=1)
        )
        work = [
            e * s if e else 0.0 for e, s in zip(strain, self.strengths, strict=True)
        ]  # an elastic sphere dissipates nothing
        return work[int(np.argmin(self.strengths))] / sum(work)


def of_loading(one):
    """Rows of the differences from the law at two overlaps, and over two ranges of the overlap."""
    for spot in SPOTS:
        yield gw.Row(f"Deviation of finite elements from the law at {spot:g} alpha_y, {one.name}", "%", theory=0.0, digits=2,
                     ours=100 * one.near(spot, one.scaled, one.over_law), where="thesis Fig. 2.8")  # fmt: skip
    deep = one.scaled > SPOTS[-1]
    spans = "1 to 10 alpha_y", f"10 alpha_y to {one.depth[-1]:.2g} R*"
    for chosen, span, remark in zip(((one.scaled >= 1) & ~deep, deep), spans, REMARKS, strict=True):
        over = 100 * one.over_law[chosen]
        for word, ours in (("smallest", over.min()), ("largest", over.max())):
            worst = one.identical and abs(ours) == np.abs(over).max()
            yield gw.Row(f"Deviation of finite elements from the law from {span}: {word}, {one.name}", "%", theory=0.0, digits=2,
                         source=math.copysign(6.0, ours) if worst else None, ours=ours, where="thesis 2.1.2",
                         remark=remark if worst else "")  # fmt: skip


def of_pressure(one):
    """Rows of pressure, contact area and force divided by the values of Thornton's law."""
    largest = max(np.median(values[values > 0]) for values in one.pressures) / min(one.strengths)
    area, force, over = (
        one.near(DEEP, one.depth, values) for values in (one.area, one.force, one.over_law)
    )
    law = force / (1 + over)
    plateau = PLATEAU / FIRST_YIELD
    deep = f"at {DEEP:g} R*, {one.name}"
    of_law = "Theory: the contact law."
    fitted = f"2.31 times 2.1 is 4.85; a measurement was fitted with 4.7. {of_law}"
    # fmt: off
    for what, source, ours, theory, remark in (
        ("Largest pressure / yield strength", 2.5, largest, PLATEAU,
         "The value is the median over the contact. The theory is the law."),
        ("Largest pressure / Thornton's pressure", 2.31, largest / FIRST_YIELD, plateau, of_law),
        (f"Contact area / Thornton's contact area {deep}", 2.1, area, law / plateau, of_law),
        (f"Force / force of Thornton's pressure and area {deep}", 4.7, force, law, fitted),
    ):
        yield gw.Row(what, source=source, ours=ours, theory=theory, where="thesis 2.1.2", remark=remark, digits=3)
    # fmt: on


def rows(runs):
    found = sorted(map(Contact, runs), key=lambda one: (not one.like, one.ratio, one.name))
    for one in found:
        yield from of_loading(one)
    alike, *unlike_radii = [one for one in found if one.like]
    for one in unlike_radii:
        deep = [1 + each.near(DEEP, each.depth, each.over_law) for each in (one, alike)]
        what = f"Finite elements at {DEEP:g} R*, {one.name} / finite elements of equal radii"
        remark = "According to the caption of the figure the curves begin to deviate there."
        yield gw.Row(what, "%", ours=100 * (deep[0] / deep[1] - 1), theory=0.0, where="thesis Fig. 2.10",
                     remark=remark, digits=2)  # fmt: skip
    yield from of_pressure(alike)
    for one in found:
        if one.strengths[0] != one.strengths[1]:
            yield gw.Row(f"Fraction of the plastic dissipation in the softer sphere, {one.name}",
                ours=one.share_of_softer,
                         where="thesis 3.1, Fig. 3.1", remark=(
                             "According to the source nearly all dissipation is in the softer "
                             "sphere."), digits=3)  # fmt: skip
    for one in found:
        for word, key, source in (("Smallest", "min", 1.30), ("Largest", "max", 1.42)):
            printed = source if one.identical else None
            yield gw.Row(f"{word} unloading exponent, {one.name}", source=printed, digits=3, where="thesis 2.1",
                         ours=one.run[f"unloading_exponent_{key}"])  # fmt: skip
