"""A run for scripts and notebooks: its summary, tables and figures; units of columns are in
``attrs["units"]``.
"""

from __future__ import annotations

import dataclasses
import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.analysis.errors import (
    MissingDataError,
    MissingOutputError,
    OutputFormatError,
    did_you_mean,
)
from granwave.analysis.exports.selection import SelectedRows, between, selection
from granwave.analysis.exports.to_tables import CSV_TABLES, place_of_column
from granwave.analysis.lammps_output.dumps import read_frame_forces
from granwave.analysis.measures.contact_geometry import UNITS as PLACE_UNITS
from granwave.analysis.measures.contact_geometry import contact_geometry
from granwave.analysis.quantities import quantity
from granwave.analysis.result.not_a_run import why_no_run
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.analysis.summary_table import SummaryRow, explanation, lines, rows_of, summary_rows
from granwave.lammps_inputs.case.figures import Figures, read_figures
from granwave.lammps_inputs.deck.columns import FORCES_AT_FRAMES
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.result_kinds import ResultKind
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE, SUMMARY_FILE

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

    from granwave.lammps_inputs.case.case import Case

UNITS = "units"  # key in ``attrs``
_AT_SNAPSHOTS = tuple(column.name for column in FORCES_AT_FRAMES)  # i, j, then forces
_INDEX = {
    "spheres": "id",
    "energy": "time",
    "probes": "time",
}  # column that names the rows of a table


def frame_of(
    columns: Mapping[str, Any], units: Mapping[str, str], index: str = ""
) -> pandas.DataFrame:
    """Make a DataFrame of columns.

    Parameters
    ----------
    columns
        Values by name: (n_rows,) or (n_rows, 3), which becomes the columns ``NAME_x``, ``NAME_y``
        and ``NAME_z``.
    units
        Unit of each of ``columns``, "1" if dimensionless.
    index
        Name of the column that becomes the index; empty for rows that are numbered.
    """
    import pandas

    split: dict[str, Any] = {}
    for name, values in columns.items():
        parts = (
            zip(("_x", "_y", "_z"), np.transpose(values), strict=True)
            if np.ndim(values) == 2
            else [("", values)]
        )
        split |= {f"{name}{axis}": (part, units[name]) for axis, part in parts}
    table = pandas.DataFrame({name: part for name, (part, _) in split.items()})
    if index:
        table = table.set_index(index)
    table.attrs[UNITS] = {name: unit for name, (_, unit) in split.items()}
    return table


class Values(Mapping[str, Any]):
    """Values of a summary.json, as a mapping.

    Attributes
    ----------
    summary
        Content of summary.json.
    """

    def __init__(self, summary: Mapping[str, Any]) -> None:
        self.summary: dict[str, Any] = dict(summary)

    def __getitem__(self, key: str) -> Any:
        return self.summary[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.summary)

    def __len__(self) -> int:
        return len(self.summary)


class Run(Values):
    """Results of one run; a mapping of the values of its summary.json.

    Tables and fields are read from result.h5 on first access.

    Parameters
    ----------
    directory
        Directory of the run.
    labels
        Values of the varied keys, if it is a point of a scan.

    Attributes
    ----------
    directory
        Absolute path of the directory.
    name
        Name of the case.
    summary
        Content of summary.json.
    labels
        Values of the varied keys by dotted key; empty if it is no point of a scan.

    Raises
    ------
    MissingOutputError
        The directory holds no results of a run.
    OutputFormatError
        They are damaged.
    """

    def __init__(self, directory: str | Path, labels: Mapping[str, Any] | None = None) -> None:
        path = Path(directory)
        super().__init__(ResultDirectory(path).summary() if path.is_dir() else {})
        if "name" not in self.summary:
            summary = path / SUMMARY_FILE
            if not path.is_dir() or not (path / RESULT_FILE).exists():
                raise MissingOutputError(why_no_run(path))
            if summary.exists():
                raise OutputFormatError(
                    f"{summary}: is damaged: recreate it with  granwave analyse {path}"
                )
            raise MissingOutputError(f"{summary} is missing: make it with  granwave analyse {path}")
        self.directory = path.absolute()
        self.name = str(self.summary["name"])
        self.labels: dict[str, Any] = dict(labels or {})

    def __getitem__(self, key: str) -> Any:
        """Return a value of summary.json, such as ``peak_force_N``.

        Raises
        ------
        MissingDataError
            There is no such value (also a KeyError).
        """
        try:
            return self.summary[key]
        except KeyError:
            hint = did_you_mean(str(key), self.summary) or "keys() lists them"
            raise MissingDataError(
                f"{self.directory / SUMMARY_FILE}: has no value {key}; {hint}"
            ) from None

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (
            self.directory,
            self.labels,
        )  # read again, as open files cannot be sent to other processes

    def __repr__(self) -> str:
        return (
            f"{lines([(row.label, row.text) for row in self._rows])}\n\nresults in {self.directory}"
        )

    def _repr_html_(self) -> str:
        row = '<tr title="{}"><th style="text-align: left">{}</th><td style="text-align: left">{}</td></tr>'
        cells = [("\n".join(map(explanation, one.keys)), one.label, one.text) for one in self._rows]
        rows = "\n".join(row.format(*map(html.escape, texts)) for texts in cells)
        place = html.escape(f"results in {self.directory}")
        return f"<table>\n{rows}\n</table>\n<p>{place}</p>"

    @property
    def _rows(self) -> list[SummaryRow]:
        return summary_rows(self.summary, rows_of(self._kind.rows))

    @cached_property
    def _kind(self) -> ResultKind:
        return ResultDirectory(self.directory).kind

    def unit(self, key: str) -> str:
        """Return the SI unit of a value, "1" if dimensionless.

        Raises
        ------
        MissingDataError
            There is no such value.
        """
        self[key]
        return quantity(key).unit or "1"

    @cached_property
    def result(self) -> Result:
        """Reader of result.h5, for all that has no table: ``run.result["contacts/force"]`` is a
        numpy array.

        Raises
        ------
        MissingOutputError
            There is no result.h5.
        OutputFormatError
            It is damaged, or of a run that is not of spheres, which h5py reads.
        """
        return Result(self.directory)

    @property
    def case(self) -> Case:
        """Case that was run; from its case.toml if result.h5 was removed."""
        if not (self.directory / RESULT_FILE).exists():
            from granwave.lammps_inputs.load_case import read_stored_case

            return read_stored_case(self.directory / CASE_FILE)
        return self.result.case

    # ------------------------------------------------------------------ tables

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables that `table` returns."""
        return tuple(name for name in CSV_TABLES if name in self.result)

    def table(self, name: str) -> pandas.DataFrame:
        """Return a table of result.h5, such as ``probes``, with its units in ``attrs["units"]``.

        Raises
        ------
        MissingDataError
            The run has no such table.
        """
        result = self.result
        there = self.tables
        if name not in there:
            hint = f"{did_you_mean(str(name), there, 0.7)} ".lstrip()
            raise MissingDataError(
                f"{result.path}: has no table {name}; {hint}it has {', '.join(there)}"
            )
        return frame_of(*self._columns(name), _INDEX.get(name, ""))

    def select(
        self,
        table: str,
        *,
        spheres: int | Iterable[int] | None = None,
        layers: int | Iterable[int] | None = None,
        depth: Sequence[float] | None = None,
        region: str | None = None,
        time: Sequence[float] | None = None,
    ) -> pandas.DataFrame:
        """Return selected rows of a table, as in ``granwave export``.

        Parameters
        ----------
        table
            ``spheres``, ``contacts``, ``wall_contacts``, ``energy``, ``probes`` or ``walls``.
        spheres
            Ids of spheres, also for their contacts.
        layers
            Numbers of layers, from 1 at the top, also for the contacts of their spheres.
        depth
            Smallest and largest depth of the centre or contact below the impacted sphere, m.
        region
            Region of the centre or contact: arguments of the LAMMPS region command, m, such as
            ``"sphere 0.04 0.04 0 0.02"``.
        time
            First and last time, s.

        Raises
        ------
        InputError
            A value is invalid, nothing is selected, or a selection does not apply to the table.
        MissingDataError
            The run has no such table.
        """
        wanted = selection(spheres, layers, depth, region, time)
        wanted.refuse_tables_without([table])
        if table == "walls":
            rows = self.walls
            if wanted.time:
                rows = rows[between(rows["time"].to_numpy(), wanted.time)]
        else:
            rows = self.contacts if table == "contacts" else self.table(table)
            mask = SelectedRows(self.result, wanted).of_table(table)
            rows = rows if mask is None else rows[mask]
        return rows

    def _columns(self, group: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
        """Return the columns of a group of result.h5, and their units."""
        names = sorted(self.result.names(group), key=place_of_column)
        values = {name: self.result.read(f"{group}/{name}") for name in names}
        return values, {name: self.result.unit(f"{group}/{name}") for name in names}

    @cached_property
    def spheres(self) -> pandas.DataFrame:
        """Spheres, by ``id``: position, radius, mass, and the peaks and energies at the end of the
        run.
        """
        return self.table("spheres")

    @cached_property
    def contacts(self) -> pandas.DataFrame:
        """Contacts between spheres ``i`` and ``j``: pairs that touch at the start or were loaded,
        with their initial positions, see `contact_geometry`.
        """
        table = self.table("contacts")
        units = table.attrs[UNITS] | PLACE_UNITS
        table = table.assign(**contact_geometry(self.result))
        table.attrs[UNITS] = units
        return table

    @cached_property
    def contact_forces(self) -> pandas.DataFrame:
        """Forces of the loaded contacts at each snapshot: ``time``, ``i``, ``j``, ``force``,
        tangential on i.

        Raises
        ------
        MissingDataError
            The run was made without ``output.contact_forces``.
        """
        import pandas

        result = self.result
        if not result.case.output.contact_forces:
            raise MissingDataError(
                f"{result.path.parent}: its snapshots hold no contact forces; run the case again with "
                "output.contact_forces = true"
            )
        times = dict(
            zip(result[f"{GROUP}/position/step"].tolist(), result.frame_times.tolist(), strict=True)
        )
        parts = [
            pandas.DataFrame(
                {"time": times[frame.step]} | {name: frame[name] for name in _AT_SNAPSHOTS}
            )
            for frame in read_frame_forces(result.path.parent)
            if frame.step in times
        ]
        found = pandas.concat(parts, ignore_index=True).astype({"i": np.int64, "j": np.int64})
        found.attrs[UNITS] = {"time": "s", "i": "1", "j": "1"} | dict.fromkeys(
            _AT_SNAPSHOTS[2:], "N"
        )
        return found

    @cached_property
    def wall_contacts(self) -> pandas.DataFrame:
        """Contacts of the sphere ``id`` with a wall; empty if there are none."""
        if "wall_contacts" not in self.result:
            return frame_of({"wall": [], "id": []}, {"wall": "1", "id": "1"})
        return self.table("wall_contacts")

    @cached_property
    def walls(self) -> pandas.DataFrame:
        """Histories of the forces on walls, below each other: ``wall``, ``time``, ``force``; empty
        without walls.

        Forces are positive outwards. Bottoms that move have further columns, NaN for other walls.
        """
        import pandas

        units = {"wall": "1", "time": "s", "force": "N"}
        parts = []
        for wall in self.result.names("walls"):
            values, own = self._columns(f"walls/{wall}")
            parts.append(pandas.DataFrame({"wall": wall} | values))
            units |= own
        found = (
            pandas.concat(parts, ignore_index=True)
            if parts
            else pandas.DataFrame({name: [] for name in units})
        )
        found.attrs[UNITS] = {str(name): units[str(name)] for name in found.columns}
        return found

    @cached_property
    def energies(self) -> pandas.DataFrame:
        """Terms of the energy balance by ``time``."""
        return self.table("energy")

    # ------------------------------------------------------------------ fields

    @cached_property
    def fields(self) -> xarray.Dataset:
        """Snapshots of all spheres; see `granwave.analysis.notebook.datasets.fields`."""
        from granwave.analysis.notebook import datasets

        return datasets.fields(self.result)

    @cached_property
    def chain(self) -> xarray.Dataset:
        """History of a chain and its bars; see `granwave.analysis.notebook.datasets.chain`.

        Raises
        ------
        MissingDataError
            The run is not of a chain, or its history was not recorded.
        """
        from granwave.analysis.notebook import datasets

        return datasets.chain(self.result)

    # ------------------------------------------------------------------ figures

    @cached_property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that apply to this run; none unless the run is of spheres.

        Figures that are not in its directory yet are drawn to find out whether they apply, which
        takes seconds once.
        """
        from granwave.analysis.figures.run_figures import run_figures
        from granwave.analysis.figures.style import Drawing, FigureFolder, attempt, style

        if not self._kind.of_spheres:
            return ()
        folder = FigureFolder(self.directory)
        there = set(folder.names()) - folder.not_drawn().keys()
        with style():
            return tuple(
                name
                for name, figure in run_figures().items()
                if name in there
                or isinstance(attempt(f"figure {name}", partial(figure.draw, self.result)), Drawing)
            )

    def figure(
        self,
        name: str,
        ax: Axes | Sequence[Axes] | None = None,
        plane: str | Sequence[float] | Mapping[str, Any] | None = None,
        against: Run | None = None,
        depths: Sequence[float] | None = None,
    ) -> Axes | list[Axes]:
        """Draw a figure for further editing; it is not saved.

        Parameters
        ----------
        name
            Name of the figure.
        ax
            Axes to draw into; of a figure of several panels a list of axes. By default a new
            figure.
        plane
            Plane of figures that end in _section, and of the contact network: ``"x"``, a normal
            (3,), or a mapping as ``figures.plane`` of a case.
        against
            Another run, whose curves are drawn dashed over the curves of this run. Second axes,
            such as of the impulse, are removed.
        depths
            Depths of the figure force_at_depths, m, as ``figures.depths`` of a case.

        Returns
        -------
        Axes or list of Axes
            Axes of the figure, which pyplot shows; a list if there are several. Colour bars are
            omitted.

        Raises
        ------
        MissingDataError
            There is no figure of this name, or it does not apply to this run, or it has no curves
            to be overlaid.
        InputError
            The axes do not suit the panels, or plane or depths are invalid.
        """
        from granwave.analysis.figures.run_figures import (
            FIXED_PLANES,
            run_figures,
            why_not_drawn,
        )
        from granwave.analysis.figures.series import draw_axes, drawn_over, no_figure
        from granwave.analysis.figures.user_axes import (
            UserFigure,
            add_curves,
            fit_to_axes,
            laid_out,
            plots_of,
        )

        if not self._kind.of_spheres:
            raise no_figure(self.name, name, ())
        if name not in run_figures():
            raise no_figure(self.name, name, run_figures())
        if plane is not None and name.endswith(FIXED_PLANES):
            start = name.rpartition("_")[0]
            raise InputError(
                f"plane: found for the figure {name}, which has a plane of its own; use "
                f"{start}_section"
            )
        figure = run_figures()[name]
        into: list[Axes] = []
        if ax is not None:
            into = list(np.ravel(np.array(ax, dtype=object)))
        over = nullcontext() if against is None else drawn_over()
        with self._options(plane, depths) as options, over:
            axes = draw_axes(lambda: figure.draw(self.result), options.width, into)
        if axes is None:
            raise MissingDataError(f"{self.name}: figure {name} {why_not_drawn(name)}")
        if against is not None:
            with against._options(plane, depths), drawn_over():
                drawing = figure.draw(against.result)
            others = [] if drawing is None else plots_of(drawing.figure)
            names = [self.name, against.name]
            if self.name == against.name:
                names = [self.directory.name, against.directory.name]
            own, other = names
            panels = axes if isinstance(axes, list) else [axes]
            if not add_curves(panels, others, other, own):
                raise MissingDataError(
                    f"{self.name}: figure {name} has no curves that can be overlaid with "
                    f"{against.name}; gw.compare shows maps of several runs"
                )
            if into:
                with laid_out(into):
                    fit_to_axes(UserFigure(into))
            left = [panel for panel in panels if panel.get_figure() is not None]
            return left[0] if len(left) == 1 else left
        return axes

    @contextmanager
    def _options(self, plane: Any, depths: Any) -> Iterator[Figures]:
        """Use another plane of sections and other depths in the ``with`` block, unless they are
        None; yield the options of figures.
        """
        options = self.result.figure_options
        table: dict[str, Any] = {}
        if plane is not None:
            is_table = isinstance(plane, str | Mapping)
            table["plane"] = plane if is_table else {"normal": [float(part) for part in plane]}
        if depths is not None:
            table["depths"] = [float(depth) for depth in np.atleast_1d(depths)]
        own = read_figures(table, "run.figure")
        changes = {name: getattr(own, name) for name in table}
        self.result.figure_options = dataclasses.replace(options, **changes)
        try:
            yield self.result.figure_options
        finally:
            self.result.figure_options = options
