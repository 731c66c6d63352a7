"""Figures of the examples for LAMMPS: runs `plugins/examples/in.NAME` with plain `lmp` and draws
its output.

    python docs/_ext/lammps_figures.py [NAME ...]       # writes docs/lammps/NAME.webp, and the digest of its script

Each script runs in ``build/lammps/NAME``. A test compares the digests in
``docs/lammps/figures.txt`` with the scripts, so that no figure comes from an earlier script.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

import granwave as gw

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "plugins" / "examples"
PAGES = ROOT / "docs" / "lammps"
RUNS = ROOT / "build" / "lammps"
DIGESTS = PAGES / "figures.txt"
#: Runs of a script, if not one on one rank: ranks and options of each.
PARTS = {
    "restart": (
        (1, ("-var", "part", "whole")),
        (2, ("-var", "part", "first")),
        (1, ("-var", "part", "second")),
    )
}


def frames(path: Path) -> list[dict[str, np.ndarray]]:
    """Return the snapshots of a dump (``custom`` or ``local``): values by column name."""
    found = []
    for text in path.read_text(encoding="utf-8").split("ITEM: TIMESTEP\n")[1:]:
        lines = text.splitlines()
        head = next(
            n
            for n, line in enumerate(lines)
            if line.startswith("ITEM:") and len(line.split()) > 3 and "BOX" not in line
        )
        if "NUMBER" in lines[head]:
            head = max(n for n, line in enumerate(lines) if line.startswith("ITEM:"))
        values = np.array([line.split() for line in lines[head + 1 :]], dtype=float)
        names = lines[head].split()[2:]
        found.append(dict(zip(names, values.reshape(-1, len(names)).T, strict=True)))
    return found


def discs(
    axes: plt.Axes, x: np.ndarray, y: np.ndarray, radius: np.ndarray, **style: object
) -> EllipseCollection:
    """Draw spheres seen along an axis."""
    size = 2 * radius
    drawn = EllipseCollection(
        size,
        size,
        np.zeros_like(size),
        units="x",
        offsets=np.c_[x, y],
        offset_transform=axes.transData,
        **style,
    )
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.autoscale_view()
    return drawn


def axes_of(
    columns: int, width: float = 6.4, height: float = 2.7, **options: object
) -> tuple[Figure, list[plt.Axes]]:
    """Return a figure with axes side by side."""
    figure, axes = plt.subplots(
        1, columns, figsize=(width, height), layout="constrained", squeeze=False, **options
    )
    return figure, list(axes[0])


def pour(run: Path) -> Figure:
    figure, (left, right) = axes_of(2, width_ratios=(1, 1.7))
    end = frames(run / "pour.dump")[0]
    order = np.argsort(-end["y"])
    discs(
        left,
        *(1e3 * end[name][order] for name in ("x", "z", "radius")),
        array=-end["y"][order],
        cmap="Greys_r",
        ec="k",
        lw=0.3,
    )
    left.set(xlabel="x, mm", ylabel="z, mm", xlim=(-30, 30), ylim=(0, None))
    step, *energies = np.loadtxt(run / "pour.txt").T
    right.stackplot(
        1e-5 * step,
        *(1e3 * one for one in (energies[0], energies[1], energies[3], energies[4])),
        labels=("motion", "height", "friction", "damping"),
    )
    right.axvline(1.0, color="k", lw=0.8, ls=":")
    right.legend(loc="center right", frameon=True)
    right.set(xlabel="time, s", ylabel="energy, mJ", xlim=(0, 1.5))
    return figure


def restitution(run: Path) -> Figure:
    figure, (axes,) = axes_of(1, 4.4)
    speed, e, theory = np.loadtxt(run / "restitution.txt").T
    axes.loglog(speed, theory, label="Thornton, closed form")
    axes.loglog(speed, e, "o", label="LAMMPS")
    axes.set(xlabel="speed of approach, m/s", ylabel="restitution")
    axes.legend()
    return figure


def chain(run: Path) -> Figure:
    figure, (left, right) = axes_of(2)
    shots = frames(run / "chain.dump")
    time = 5e-6 * np.arange(len(shots)) * 1e6  # 250 steps of 2e-8 s
    speed, force = (np.array([shot[name] for shot in shots]) for name in ("vz", "c_bead[1]"))
    for bead in (10, 20, 30, 40, 50):
        left.plot(time, speed[:, bead - 1], label=str(bead))
    left.set(xlabel="time, µs", ylabel="speed, m/s")
    left.legend(
        title="bead", ncols=2, loc="upper right", fontsize="x-small", title_fontsize="x-small"
    )
    left.set_ylim(top=1.35 * speed[:, 9].max())
    picture = right.pcolormesh(
        np.arange(1, force.shape[1] + 1), time, force, cmap="viridis", rasterized=True
    )
    figure.colorbar(picture, label="largest contact force, N")
    right.set(xlabel="bead", ylabel="time, µs")
    return figure


def block(run: Path) -> Figure:
    figure, (left, right) = axes_of(2, width_ratios=(1.25, 1))
    step, push, floor = np.loadtxt(run / "block.txt").T
    left.plot(2e-2 * step, 1e-3 * push, label="on the striker")
    left.plot(2e-2 * step, -1e-3 * floor, label="on the floor")
    left.set(xlabel="time, µs", ylabel="force, kN")
    left.legend()
    end = frames(run / "block.dump")[0]
    y = np.unique(np.round(end["y"], 6))
    cut = (end["type"] == 1) & (
        np.abs(end["y"] - y[np.argmin(np.abs(y - end["y"][end["type"] == 2]))]) < 0.003
    )
    shade = discs(
        right,
        *(1e3 * end[name][cut] for name in ("x", "z", "radius")),
        array=1e-3 * end["c_sphere[2]"][cut],
        cmap="inferno",
        ec="0.5",
        lw=0.3,
    )
    figure.colorbar(shade, label="largest force, kN")
    right.set(xlabel="x, mm", ylabel="z, mm")
    return figure


def crystal(run: Path) -> Figure:
    figure, (axes,) = axes_of(1, 4.4)
    _, spacing, _, pressure, *_ = np.loadtxt(run / "crystal.txt").T
    strain = 100 * (1 - spacing / 0.01)
    turn = np.argmax(pressure)
    again = turn + np.argmin(strain[turn:])
    for part, look in (
        (slice(0, turn + 1), "C0-"),
        (slice(turn, again + 1), "C1-"),
        (slice(again, None), "k:"),
    ):
        axes.plot(strain[part], 1e-6 * pressure[part], look)
    axes.legend(["pressed", "released", "pressed again"])
    axes.set(xlabel="strain, %", ylabel="pressure, MPa")
    return figure


def rolling(run: Path) -> Figure:
    figure, pair = axes_of(2, sharey=True)
    for axes, resist in zip(pair, ("0", "0.02"), strict=True):
        step, speed, surface = np.loadtxt(run / f"rolling-{resist}.txt").T
        axes.plot(5e-6 * step, speed, label="sphere")
        axes.plot(5e-6 * step, surface, label="its surface")
        end = 1 / (9.81 * (3.5 * 0.3 - 2.5 * float(resist)))
        time = np.array([0.0, end, 0.6])
        theory = 1 - 9.81 * (
            0.3 * np.minimum(time, end) + 5 / 7 * float(resist) * np.maximum(time - end, 0)
        )
        axes.plot(time, theory, "k:", label="formula")
        axes.set(xlabel="time, s", title=f"rolling resistance {resist}")
    pair[0].set_ylabel("speed, m/s")
    pair[0].legend(loc="lower right")
    return figure


def contacts(run: Path) -> Figure:
    figure, (axes,) = axes_of(1, 6.4, 4.0)
    spheres = frames(run / "spheres.dump")[0]
    forces = frames(run / "contacts.dump")[0]
    x = 1e3 * spheres["x"]
    y = 1e3 * spheres["y"]
    discs(axes, x, y, 1e3 * spheres["radius"], fc="0.93", ec="0.8", lw=0.3)
    i, j = (forces[f"c_contact[{n}]"].astype(int) - 1 for n in (1, 2))
    force = forces["c_contact[4]"] / forces["c_contact[4]"].mean()
    lines = LineCollection(
        np.stack([np.c_[x[i], y[i]], np.c_[x[j], y[j]]], axis=1),
        linewidths=1.3 * force,
        array=force,
        cmap="inferno_r",
    )
    axes.add_collection(lines)
    figure.colorbar(lines, label="normal force / mean")
    axes.set(xlabel="x, mm", ylabel="y, mm", xlim=(-100, 100), ylim=(0, None))
    return figure


def restart(run: Path) -> Figure:
    figure, (axes,) = axes_of(1, 4.4)
    for part, look in (("whole", "-"), ("first", "o"), ("second", "x")):
        step, motion, turning, yielded, rubbed, _ = np.loadtxt(run / f"{part}.txt")[
            :: 1 if part == "whole" else 10
        ].T
        for value, colour, name in (
            (motion + turning, "C0", "motion"),
            (yielded, "C1", "yielding"),
            (rubbed, "C2", "friction"),
        ):
            axes.plot(
                5e-5 * step,
                1e3 * value,
                look,
                color=colour,
                ms=4,
                mfc="none",
                label=name if look == "-" else None,
            )
    axes.axvline(1.0, color="k", lw=0.8, ls=":")
    axes.legend()
    axes.set(xlabel="time, ms", ylabel="energy, mJ")
    return figure


def clumps(run: Path) -> Figure:
    figure, (left, right) = axes_of(2, width_ratios=(1.2, 1))
    end = frames(run / "clumps.dump")[0]
    order = np.argsort(-end["y"])
    colours = np.array(["0.85", "C0", "C1", "C2"])[end["mol"][order].astype(int)]
    discs(
        left, *(1e3 * end[name][order] for name in ("x", "z", "radius")), fc=colours, ec="k", lw=0.3
    )
    left.set(xlabel="x, mm", ylabel="z, mm")
    step, *parts = np.loadtxt(run / "clumps.txt").T
    energies = parts[0] + parts[1], parts[2] + parts[3], parts[4] + parts[6], parts[5], parts[7]
    right.stackplot(
        2e-5 * step,
        *(1e3 * one for one in energies),
        labels=("block", "clumps", "stored", "yielding", "friction"),
    )
    right.legend(loc="lower left", frameon=True)
    right.set(xlabel="time, ms", ylabel="energy, mJ", xlim=(0, 1))
    return figure


def timestep(run: Path) -> Figure:
    figure, (left, right) = axes_of(2)
    for way in ("fixed", "adaptive"):
        step, taken, error = np.loadtxt(run / f"timestep-{way}.txt").T
        left.semilogy(5e-3 * step, 1e9 * taken, label=way)
        right.semilogy(5e-3 * step[1:], np.abs(error[1:]), label=way)
    left.set(xlabel="time, µs", ylabel="timestep, ns")
    right.axhline(1e-6, color="k", lw=0.8, ls=":")
    right.set(xlabel="time, µs", ylabel="error of the energy balance", ylim=(1e-11, 3e-6))
    right.legend(loc="lower right")
    return figure


def chute(run: Path) -> Figure:
    figure, (left, right) = axes_of(2)
    step, speed, *_, shear, normal = np.loadtxt(run / "chute.txt").T
    left.plot(3e-5 * step, speed, label="mean speed, m/s")
    left.plot(3e-5 * step, -shear / normal, lw=0.7, label="shear / normal force")
    left.axhline(np.tan(np.radians(26)), color="k", ls=":", label="tan 26 degrees")
    left.set(xlabel="time, s", ylim=(0, 1.5))
    left.legend()
    rows = [
        line.split()
        for line in (run / "chute-profile.txt").read_text().splitlines()
        if line.startswith("  ")
    ]
    height, number, velocity = np.array(rows, dtype=float)[len(rows) // 2 :, [1, 2, 4]].T
    filled = number > 0.1 * number.max()
    z = 1e3 * height[filled]
    v = velocity[filled]
    right.plot(v, z, "o", label="LAMMPS")
    top = z.max()
    shape = 1 - (1 - z / top) ** 1.5
    right.plot(shape * (shape @ v) / (shape @ shape), z, label="Bagnold's profile")
    right.set(xlabel="speed, m/s", ylabel="height, mm")
    right.legend(loc="upper left")
    return figure


#: In the order of the pages.
FIGURES: dict[str, Callable[[Path], Figure]] = {
    one.__name__: one
    for one in (
        pour,
        restitution,
        chain,
        block,
        crystal,
        rolling,
        contacts,
        restart,
        clumps,
        timestep,
        chute,
    )
}


def digest(name: str) -> str:
    """Return the digest of a script without its comments and the files that it reads."""
    text = (SCRIPTS / f"in.{name}").read_text(encoding="utf-8")
    return hashlib.sha256(
        "\n".join(line.partition("#")[0].rstrip() for line in text.splitlines()).encode()
    ).hexdigest()[:16]


def run(name: str, folder: Path, options: tuple[str, ...] = ()) -> None:
    """Run an example in a folder.

    Raises
    ------
    CalledProcessError
        LAMMPS ended with an error, which is in its log.
    """
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(SCRIPTS, folder)
    programs = Path(sys.executable).parent
    for ranks, part in PARTS.get(name, ((1, ()),)):
        launch = [str(programs / "mpiexec"), "-n", str(ranks)] if ranks > 1 else []
        command = [
            *launch,
            str(programs / "lmp"),
            "-in",
            f"in.{name}",
            "-screen",
            "none",
            *part,
            *options,
        ]
        subprocess.run(command, cwd=folder, check=True)


def main(names: list[str]) -> None:
    """Run the examples of these names, or all, and draw their figures."""
    digests = (
        dict(line.split() for line in DIGESTS.read_text().splitlines()) if DIGESTS.exists() else {}
    )
    for name in names or FIGURES:
        run(name, RUNS / name)
        with gw.style():
            figure = FIGURES[name](RUNS / name)
            figure.savefig(PAGES / f"{name}.webp", dpi=150, pil_kwargs={"quality": 80})
            plt.close(figure)
        digests[name] = digest(name)
        DIGESTS.write_text("".join(f"{one} {digests[one]}\n" for one in FIGURES if one in digests))


if __name__ == "__main__":
    main(sys.argv[1:])
