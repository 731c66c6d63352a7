"""Open the spheres and the contacts of a run together in OVITO.

    python open_in_ovito.py [RUN] [--scene FILE] [--picture FILE]

needs only the ``ovito`` package (``pip install ovito``); OVITO Pro runs it directly (File > Run
Python Script). It saves a scene that also OVITO Basic can open, which has no Python. Spheres come
from ``data.granwave`` and ``dumps/spheres.bin`` (``spheres.dump`` if the snapshots are text);
contacts are bonds, from ``dumps/contacts.dump``. Lengths are metres.

Spheres are drawn at `SPHERE_SCALE` of their radius, so that the contacts between them are visible,
and coloured by the decimal logarithm of their peak force so far (N). A contact appears with the
snapshot that follows its first load; its colour and width show its peak force during the run, and
its other columns (peak_overlap, dissipated, time_yield ...) are bond properties, in SI units.
"""

from __future__ import annotations

import argparse
import math
import tomllib
from pathlib import Path
from typing import Any

RUN = ".."  # the run's directory, as seen from this file
NEEDED = ("case.toml", "data.granwave", "dumps/contacts.dump")
SNAPSHOTS = ("dumps/spheres.bin", "dumps/spheres.dump")  # the file is one of these
SPHERE_SCALE = 0.4
CONTACT_WIDTH = 0.25  # width of the strongest contact, diameters
DECADES = 4  # range of the colour scale of peak forces
VIEW = (-0.46, 0.73, 0.5)  # viewing direction; depth, along +z, is downwards in the image
PIXELS = (1200, 1000)


def build(run: Path) -> Any:
    """Build the pipeline of a run: snapshots of the spheres, and contacts as bonds.

    Parameters
    ----------
    run
        Directory with the files `NEEDED` and one of `SNAPSHOTS`.

    Returns
    -------
    ovito.pipeline.Pipeline
        Pipeline, not yet added to the scene.
    """
    from ovito.io import import_file
    from ovito.modifiers import (
        ColorCodingModifier,
        ComputePropertyModifier,
        DeleteSelectedModifier,
        ExpressionSelectionModifier,
        LoadTrajectoryModifier,
    )

    case = tomllib.loads((run / "case.toml").read_text(encoding="utf-8"))
    sides = case.get("boundary", {}).get("sides") == "periodic"
    contacts_file = run / "dumps" / "contacts.dump"

    # The data file first and the snapshots last, so that bonds remain and the time step is that of
    # the snapshot.
    pipeline: Any = import_file(str(run / "data.granwave"), atom_style="sphere")
    pipeline.source.data.cell_.pbc = (sides, sides, False)
    if columns := _columns(contacts_file):
        contacts = LoadTrajectoryModifier()
        contacts.source.load(str(contacts_file), columns=columns)
        pipeline.modifiers.append(contacts)
    snapshots = LoadTrajectoryModifier()
    snapshots.source.load(_snapshots(run))
    pipeline.modifiers.append(snapshots)

    last = pipeline.compute(pipeline.num_frames - 1)
    strongest = max(float(last.particles["peak_force"][...].max()), 1e-300)
    top = math.log10(strongest)

    def coloured(what: str) -> None:
        logarithm = f"log10(max(peak_force, {strongest * 10.0**-DECADES!r}))"
        name = "log10(peak_force/N)"
        pipeline.modifiers.append(
            ComputePropertyModifier(operate_on=what, output_property=name, expressions=[logarithm])
        )
        scale: dict[str, Any] = {
            "start_value": top - DECADES,
            "end_value": top,
            "gradient": ColorCodingModifier.Viridis(),
        }
        pipeline.modifiers.append(ColorCodingModifier(operate_on=what, property=name, **scale))

    coloured("particles")
    if columns:
        later = f"time_first < 0 || time_first > Timestep*{float(case['resolved']['timestep'])!r}*(1+1e-9)"
        pipeline.modifiers.append(ExpressionSelectionModifier(operate_on="bonds", expression=later))
        pipeline.modifiers.append(DeleteSelectedModifier(operate_on={"bonds"}))
        coloured("bonds")
        width = f"{CONTACT_WIDTH * case['packing']['diameter']!r}*sqrt(peak_force/{strongest!r})"
        pipeline.modifiers.append(
            ComputePropertyModifier(
                operate_on="bonds", output_property="Width", expressions=[width]
            )
        )
    return pipeline


def show(pipeline: Any) -> Any:
    """Add the pipeline to the scene; return a viewport with the impacted layer up."""
    import ovito
    from ovito.vis import Viewport

    pipeline.add_to_scene()
    data = pipeline.compute(pipeline.num_frames - 1)
    data.particles.vis.scaling = SPHERE_SCALE
    data.cell.vis.enabled = False
    scene: Any = ovito.scene
    viewport = scene.viewports.active_vp or Viewport()
    viewport.type = Viewport.Type.Ortho
    viewport.camera_dir = VIEW
    viewport.camera_up = (0.0, 0.0, -1.0)
    viewport.zoom_all(size=PIXELS)
    return viewport


def _snapshots(run: Path) -> list[str]:
    """Return the files of the snapshots; a resumed run has several."""
    first = next(run / name for name in SNAPSHOTS if (run / name).is_file())
    parts = sorted(
        (run / "dumps").glob("spheres-*.bin"), key=lambda path: int(path.stem.partition("-")[2])
    )
    return [str(path) for path in (first, *parts) if path.stat().st_size]


def missing_files(run: Path) -> list[str]:
    """Return the missing files for `build`."""
    found = [name for name in SNAPSHOTS if (run / name).is_file()]
    return [
        name for name in (*NEEDED, *([] if found else SNAPSHOTS[:1])) if not (run / name).is_file()
    ]


def in_parts(run: Path) -> bool:
    """Return True if the dumps have several parts, which OVITO does not join."""
    return (run / "dumps" / "contacts.0.dump").is_file()


def _columns(path: Path) -> list[str]:
    """Return OVITO's names for the columns of the contacts, from the header; empty without
    contacts.
    """
    ids = {"i": "Particle Identifiers.1", "j": "Particle Identifiers.2"}
    with open(path, encoding="ascii") as file:
        count = 0
        for line in file:
            if line.startswith("ITEM: NUMBER OF ENTRIES"):
                count = int(next(file))
            if line.startswith("ITEM: ENTRIES"):
                return [ids.get(name, name) for name in line.split()[2:]] if count else []
    raise SystemExit(
        f"{path}: found no line 'ITEM: ENTRIES ...', expected the contacts of a finished run"
    )


def main() -> None:
    here = Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description="Spheres and contacts of a granwave run in OVITO.")
    parser.add_argument(
        "run", nargs="?", type=Path, default=here / RUN, help="the directory of the run"
    )
    parser.add_argument(
        "--scene",
        type=Path,
        default=here / "scene.ovito",
        help="OVITO session file (default: in the current directory)",
    )
    parser.add_argument("--picture", type=Path, help="also render the last snapshot (.png)")
    options = parser.parse_args()
    run = options.run.resolve()
    if in_parts(run):
        raise SystemExit(
            f"{run}: the dumps have several parts, which OVITO cannot combine; use granwave "
            "export --to vtp"
        )
    if missing := missing_files(run):
        raise SystemExit(
            f"{run}: {', '.join(missing)} missing; use the directory of a finished run"
        )

    import ovito

    pipeline = build(run)
    viewport = show(pipeline)
    ovito.scene.save(str(options.scene))
    data = pipeline.compute(pipeline.num_frames - 1)
    bonds = data.particles.bonds.count if data.particles.bonds is not None else 0
    print(
        f"{options.scene}: {data.particles.count} spheres, {bonds} contacts, {pipeline.num_frames} snapshots"
    )
    if options.picture:
        from ovito.vis import TachyonRenderer

        last = pipeline.num_frames - 1
        try:
            viewport.render_image(
                filename=str(options.picture), size=PIXELS, frame=last, renderer=TachyonRenderer()
            )
        except RuntimeError as error:  # without graphics libraries; the message names them
            raise SystemExit(f"{options.picture}: not drawn; {error}") from None
        print(options.picture)


if __name__ == "__main__":
    main()
