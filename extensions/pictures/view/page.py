"""Page of a run: one HTML file with the packing in three dimensions, which requires no
network.

The viewer is k3d (https://k3d-jupyter.org, on three.js), embedded as in its own snapshots of plots.
It draws hundreds of thousands of spheres as shaded discs, and has time series, clipping planes and
a panel. `panel.js` adds a few controls. A Content-Security-Policy in the page keeps the browser
from loading anything from outside.
"""

from __future__ import annotations

import base64
import html
import re
import zlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.view.fields import fields
from granwave.extensions.pictures.view.instants import instants_of
from granwave.extensions.pictures.view.scene import plot_of
from granwave.lammps_inputs.directories import refuse_other_file
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.cylinders import SPHERES
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import VIEW_FILE

if TYPE_CHECKING:
    import k3d

# a larger page is slow to load, and to rotate without a powerful graphics card
MOST_SPHERES = 250_000
MOST_VALUES = 8_000_000  # values of a field: spheres times snapshots, 4 bytes each in the browser
_FEWEST_FRAMES = 5
_PANEL = Path(__file__).with_name("panel.js")
#: Script of the message in a browser without WebGL, where the page would be blank.
_NO_WEBGL = """<script>
if (!document.createElement('canvas').getContext('webgl2')) {
    const message = document.createElement('p');
    message.id = 'no-webgl';
    message.style.cssText = 'position: fixed; z-index: 9999; margin: 1em; font-family: sans-serif';
    message.textContent = 'This browser cannot draw in 3-D: it has no WebGL 2. Switch on hardware '
        + 'acceleration in its settings, open the page in another browser, or start Chromium with '
        + '--enable-unsafe-swiftshader.';
    document.body.append(message);
}
</script>
"""
_MARK = "<!-- made by granwave: page of a run, with the viewer k3d {version} (MIT licence, https://k3d-jupyter.org) -->"
_OWN = rb"\A<!doctype html>\n<!-- made by granwave: page of a run"
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; connect-src data: blob:; base-uri 'none'; form-action 'none'"
)
_VIEWPORT = '<meta name="viewport" content="width=device-width, initial-scale=1">'  # for phones
_COMPRESSION = 6  # level 9 takes three times as long for a small gain


@dataclass(frozen=True)
class View:
    """A page that was written.

    Attributes
    ----------
    path
        Its file.
    size
        Its size, bytes.
    n_spheres, n_frames
        Numbers of spheres and snapshots on it.
    note
        A sentence on omitted data; empty if nothing is omitted.
    """

    path: Path
    size: int
    n_spheres: int
    n_frames: int
    note: str
    called: str = SPHERES


def write_view(
    directory: AnyPath, path: str | Path | None = None, *, spheres: int | None = MOST_SPHERES,
    frames: int | None = None,
) -> View:  # fmt: skip
    """Write the page of a run.

    Parameters
    ----------
    directory
        Directory of the run.
    path
        File to write, .html; by default view.html in the directory.
    spheres
        Largest number of spheres: nearest to the impacted sphere; None for all.
    frames
        Largest number of snapshots; by default as many as `MOST_VALUES` allows.

    Raises
    ------
    InputError
        Another ending or no such directory; a file of that name that granwave did not write; or a
        run in which nothing happened.
    MissingOutputError, OutputFormatError
        The directory contains no result, or a damaged result.
    """
    results = ResultDirectory.at(directory)
    target = results / VIEW_FILE if path is None else Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{target}: expected a name that ends in .html")
    if not target.absolute().parent.is_dir():
        raise InputError(f"{target}: no such directory: {target.absolute().parent}")
    with Result(results) as result:
        if path is not None:
            refuse_other_file(target, _OWN)
        instants = instants_of(result)
        called = result.assembly.grains_called
        notes = []
        rows = np.arange(result.n_spheres)
        if spheres is not None and len(rows) > spheres:
            distance = np.linalg.norm(result["spheres/position"] - result.origin, axis=1)
            notes.append(f"the {spheres} {called} nearest to the impacted sphere, of {len(rows)}")
            rows = np.sort(np.argsort(distance, kind="stable")[:spheres])
        n = len(instants.times)
        most = frames or max(_FEWEST_FRAMES, MOST_VALUES // max(1, len(rows)))
        if n > most:
            instants = instants.at(
                np.unique(np.linspace(0, n - 1, most).round().astype(int)).tolist()
            )
            notes.append(f"{len(instants.times)} of {n} snapshots")
        found = fields(result, instants, rows)
        note = f"shown: {', '.join(notes)}" if notes else ""
        if not found:
            raise InputError(
                f"{result.case.name}: nothing moved and no contact carried a force, so there is "
                "nothing to show"
            )
        page = _page(plot_of(result, instants, rows, found, note), result.case.name)
    if path is None:
        results.claim([VIEW_FILE])
    replace_text(target, page)
    return View(target, target.stat().st_size, len(rows), len(instants.times), note, called)


def _page(plot: k3d.Plot, name: str) -> str:
    """Return the page of a plot, with a title, and a policy that keeps the browser from loading
    anything.
    """
    import k3d

    text = plot.get_snapshot(_COMPRESSION, additional_js_code=_PANEL.read_text(encoding="utf-8"))
    mark = _MARK.format(version=k3d.__version__)
    charset = '<meta charset="utf-8">'
    policy = f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
    text = re.sub(
        r"(?<=window\.k3dCompressed = ')[^']+",
        lambda source: _without_fallbacks(source[0]),
        text,
        count=1,
    )
    text = text.replace("<!doctype html>", f"<!doctype html>\n{mark}", 1)
    text = text.replace(charset, f"{charset}\n    {_VIEWPORT}\n    {policy}", 1)
    body, end, rest = text.rpartition("</body>")
    text = f"{body}{_NO_WEBGL}{end}{rest}"
    title = html.escape(f"{name} - granwave")
    return re.sub(r"<title>.*?</title>", lambda _: f"<title>{title}</title>", text, count=1)


@cache
def _without_fallbacks(source: str) -> str:
    """Return the compressed source of k3d without the addresses of fonts for old browsers; the page
    contains the other fonts as data.
    """
    text = zlib.decompress(base64.b64decode(source)).decode("utf-8")
    text = re.sub(r',url\(fonts/[^)]*\) format\("\w+"\)', "", text)
    return base64.b64encode(zlib.compress(text.encode("utf-8"), _COMPRESSION)).decode("ascii")
