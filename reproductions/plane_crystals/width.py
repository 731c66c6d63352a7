"""Region 1 of a plane crystal ends where the effect of its sides begins.

Crystals with 4 to 16 grains per row are compared with a crystal of 40, at the same mass of the
plate per width, with side walls and with free sides. The peak speed of the first pulse down the
middle line is divided by the peak speed in the wide crystal; the curves separate at the depth where
the two speeds differ by 3 %. According to the source reflected waves compress the upper part
laterally (region 1), to a depth equal to the width. The front and the signals of the top corners
travel down together along the close-packed lines. They meet on the middle line at W/2 (45 degrees)
and sqrt(3)/2 W (30 degrees). Above that depth no signal of the sides has arrived; the curves of
crystals with free sides separate at the same depth.
"""

import numpy as np
from crystal import NAMES, SOURCE, Crystal
from matplotlib.figure import Figure

import granwave as gw
from granwave.measures import parted_at

# printed layers of region 1, number of grains per row inferred from them, printed decay in region 1
# (1/m); layers per diameter
PRINTED = {"BCC": (7.0, 7, 1.6, np.sqrt(2)), "HCP": (8.5, 8, 1.8, 2 / np.sqrt(3))}
# rate along the compared line / rate along the depth: the vertical, or a line at 30 degrees
ALONG = {"BCC": 1.0, "HCP": np.sqrt(3) / 2}


class Widths:
    """Crystals of one kind by width, with walls and with free sides, each with its depth of
    deviation from the wide crystal.

    The depth is NaN if the curves do not separate.
    """

    def __init__(self, name, crystals):
        *narrow, self.wide = sorted(crystals, key=lambda one: one.width)
        self.name = name
        self.pairs = (
            [one for one in narrow if one.walls],
            [one for one in narrow if not one.walls],
        )
        for one in narrow:
            n = min(one.down.fitted.stop, self.wide.down.fitted.stop)
            found = parted_at(one.depth[:n], one.peak[:n], self.wide.peak[:n])
            one.parted = np.nan if found is None else found
        self.width, *self.parted = np.array([(walls.width, walls.parted, free.parted)
                                             for walls, free in zip(*self.pairs, strict=True)]).T  # fmt: skip
        self.law = self.wide.meeting / self.wide.width


def select(runs):
    crystals = [Crystal(run) for run in runs]
    return [Widths(name, [one for one in crystals if one.name == name]) for name in NAMES.values()]


def name(group):
    return f"lateral-width-{group.name.lower()}"


def title(group):
    return f"Region 1 of a plane crystal ends where the effect of its sides begins: {group.name}"


def rows(group):
    crystal, (layers, count, decay, a_diameter) = group.name, PRINTED[group.name]
    known = np.isfinite(group.parted[0])
    slope = np.sum(group.width[known] * group.parted[0][known]) / np.sum(group.width[known] ** 2)
    width = (count - 1) * np.sqrt(2) + 1 if crystal == "BCC" else count
    line = group.wide.down
    alpha = -np.polyfit(line.distance[line.fitted], np.log(line.peak_speed[line.fitted]), 1)[0]
    # where no signal of the sides has come, the peak speed depends on the depth alone
    along = alpha * ALONG[crystal]
    way = ""
    remark = ""
    if crystal == "HCP":
        way = ", along the diagonal"
        remark = (
            " According to the source the rate along the vertical is drastically different; in our "
            f"run it is {alpha:.2g}."
        )
    # fmt: off
    yield gw.Row(f"Layers of region 1, {crystal}", "layers", layers, slope * width * a_diameter, digits=2,
                 where=f"{SOURCE}, Fig. 4 to 7", remark="This row is not a test. The source "
                                                        "does not print the width of its "
                                                        f"crystals; {count} grains per row were "
                                                        "inferred from these layers.")
    yield gw.Row(f"Depth of region 1 / width, {crystal}", "", 1.0, slope, theory=group.law, digits=2,
                 where=f"{SOURCE}, 3, Fig. 6e",
                 remark="Theory: where the signals of both top corners meet on the middle line.")
    yield gw.Row(f"Decay of the peak speed in region 1, {crystal}{way}", "1/m", decay, along, f"{SOURCE}, Fig. 7",
                 digits=2, remark="The decay is fitted by one exponential in the wide crystal. Plate "
                                  "and damping are not printed, so that only the order of magnitude "
                                  f"can be compared.{remark}")
    away = np.abs(np.array(group.parted) - group.width * group.law) / np.diff(group.wide.depth).mean()
    yield gw.Row(f"Depth of separation minus depth of the law, at most, {crystal}", "grains",
                 ours=np.nanmax(away), where=SOURCE, digits=2,
                 remark="The value is the largest of all widths, with walls and with free "
                        "sides. The resolution is one grain.")
    # fmt: on


def pictures(group):
    figure = Figure((7, 2.8), layout="constrained")
    data = {}
    left, right = figure.subplots(1, 2)
    for crystals, parted, word, line, mark, colour in zip(
        group.pairs, group.parted, ("walls", "free"), ("-", "--"), "o^", ("C0", "C1"), strict=True
    ):
        for one in crystals:
            n = min(len(one.depth), len(group.wide.depth))
            place = one.depth[:n] / one.meeting
            ratio = one.peak[:n] / group.wide.peak[:n]
            left.plot(
                place,
                ratio,
                line,
                color=colour,
                alpha=0.25 + 0.75 * one.width / group.width[-1],
                linewidth=0.9,
            )
            data |= {
                f"{word}_{one.count}_depth_diameters": one.depth[:n],
                f"{word}_{one.count}_over_wide": ratio,
            }
        right.plot(group.width, parted, mark, markersize=4, color=colour, label=word)
        data |= {"width_diameters": group.width, f"{word}_parted_diameters": parted}
    widths = np.array([0.0, group.width[-1]])
    right.plot(widths, widths * group.law, color="0.5", label="effect of the sides starts")
    right.plot(widths, widths, ":", color="0.5", label="depth = width (source)")
    left.axvline(1.0, color="0.5", linestyle=":", linewidth=0.8)
    left.set(
        xlabel="Depth / depth where signals of the sides meet", ylabel="Peak speed / wide crystal"
    )
    left.set(xlim=(0, 3), ylim=(0, 1.3))
    right.set(
        xlabel="Width (diameters)",
        ylabel="Depth of separation (diameters)",
        xlim=(0, None),
        ylim=(0, None),
    )
    right.legend()
    caption = (
        f"{group.name}: peak speeds of crystals of several widths, divided by the speeds in "
        "the widest. The curves separate where the signals of "
    )
    caption += "the two sides meet (1 on the left); that depth grows with the width"
    yield gw.Picture(f"lateral_width_{group.name.lower()}", caption, figure, data)


def tables(group):
    walls, free = group.parted
    columns = {
        "Grains a row": [one.count for one in group.pairs[0]],
        "W (D)": group.width,
        "Signals of the sides meet (D)": group.width * group.law,
        "Part, walls (D)": walls,
        "Part, free (D)": free,
    }
    yield f"Depth of region 1 by width, {group.name}", columns
