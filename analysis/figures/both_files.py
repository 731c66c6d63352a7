"""Drawing of a figure once for its PNG and its PDF.

Most of the time that matplotlib takes for a small figure goes into its artists: ticks, text and paths that are computed
again for each file. Here the artists draw once, at the resolution of the PNG, and what they draw goes to the renderers
of both files: as it is to that of the PNG, so that this is the picture that matplotlib saves, and scaled to points to
that of the PDF, which stays a drawing of paths and text.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase, RendererBase
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.backends.backend_pdf import PdfFile, RendererPdf
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Transform, TransformedBbox, TransformedPath
from numpy.typing import NDArray

from granwave.analysis.figures.formulas import share_formulas
from granwave.analysis.figures.pdf_fonts import needed_tables_only

_POINTS = 72.0  # in an inch
_Context = GraphicsContextBase


def draw_both(figure: Figure, resolution: float, metadata: dict[str, Any]) -> tuple[NDArray[np.uint8], bytes]:
    """Draw a figure, whose layout is done.

    Parameters
    ----------
    resolution
        Dots per inch of the pixels, and of pictures within the PDF.
    metadata
        Of the PDF, as `matplotlib.figure.Figure.savefig` takes it.

    Returns
    -------
    pixels, pdf
        Red, green, blue and alpha: (n_rows, n_columns, 4); and the contents of the PDF file.
    """
    stream = io.BytesIO()
    width, height = figure.get_size_inches()
    with needed_tables_only(), _resolution_of(figure, resolution):
        file = PdfFile(stream, metadata=metadata)
        try:
            file.newPage(width, height)
            pdf = RendererPdf(file, resolution, height, width)
            renderer = _Both(figure.bbox.width, figure.bbox.height, resolution, pdf)
            figure.draw(renderer)
            pdf.finalize()
            file.finalize()
        finally:
            file.close()
        return np.asarray(renderer.buffer_rgba()), stream.getvalue()


@contextmanager
def _resolution_of(figure: Figure, resolution: float) -> Iterator[None]:
    before = figure.dpi
    figure.dpi = resolution
    try:
        yield
    finally:
        figure.dpi = before


class _Both(RendererBase):
    """Renderer of pixels that passes everything on to a renderer of a PDF.

    Artists that are to be pixels in the PDF too (``rasterized``) are drawn once more by a renderer of their own, whose
    picture the PDF then gets.

    Parameters
    ----------
    width, height
        Of the pixels.
    resolution
        Dots per inch.
    pdf
        Renderer of the PDF.
    """

    def __init__(self, width: float, height: float, resolution: float, pdf: RendererPdf) -> None:
        super().__init__()
        self.width, self.height, self.dpi = width, height, resolution
        self._agg = RendererAgg(width, height, resolution)
        self._pdf = pdf
        share_formulas(self._agg)
        share_formulas(pdf)
        self._scale = _POINTS / resolution
        self._to_points = Affine2D().scale(self._scale)
        self._pixels: RendererAgg | None = None  # of artists that are pixels in the PDF

    # what artists ask; the answers are those of the renderer of pixels

    def points_to_pixels(self, points: Any) -> Any:
        """Return lengths in pixels."""
        return self._agg.points_to_pixels(points)

    def get_canvas_width_height(self) -> tuple[float, float]:
        """Return the size in pixels."""
        return self.width, self.height

    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> tuple[float, float, float]:
        """Return width, height and descent of a text in pixels."""
        return self._agg.get_text_width_height_descent(s, prop, ismath)

    def option_image_nocomposite(self) -> bool:
        """Return True: pictures are drawn one by one."""
        return True

    def buffer_rgba(self) -> memoryview:
        """Return the pixels."""
        return self._agg.buffer_rgba()

    # what artists draw

    def draw_path(self, gc: _Context, path: Path, transform: Transform, rgbFace: Any = None) -> None:
        """Draw a path."""
        self._agg.draw_path(gc, path, transform, rgbFace)
        if not self._as_pixels("draw_path", gc, path, transform, rgbFace):
            self._pdf.draw_path(self._context(gc), path, transform + self._to_points, rgbFace)

    def draw_markers(
        self,
        gc: _Context,
        marker_path: Path,
        marker_trans: Transform,
        path: Path,
        trans: Transform,
        rgbFace: Any = None,
    ) -> None:
        """Draw a marker at each point of a path."""
        self._agg.draw_markers(gc, marker_path, marker_trans, path, trans, rgbFace)
        if not self._as_pixels("draw_markers", gc, marker_path, marker_trans, path, trans, rgbFace):
            scaled = marker_trans + self._to_points, path, trans + self._to_points
            self._pdf.draw_markers(self._context(gc), marker_path, *scaled, rgbFace)

    def draw_path_collection(
        self,
        gc: _Context,
        master_transform: Transform,
        paths: Any,
        all_transforms: Any,
        offsets: Any,
        offset_trans: Transform,
        *rest: Any,
        **options: Any,
    ) -> None:
        """Draw many paths."""
        shapes = paths, all_transforms, offsets
        self._agg.draw_path_collection(gc, master_transform, *shapes, offset_trans, *rest, **options)
        if self._as_pixels("draw_path_collection", gc, master_transform, *shapes, offset_trans, *rest, **options):
            return
        master, offset = self._scaled(master_transform), self._scaled(offset_trans)
        self._pdf.draw_path_collection(self._context(gc), master, *shapes, offset, *rest, **options)

    def draw_quad_mesh(
        self,
        gc: _Context,
        master_transform: Transform,
        meshWidth: int,
        meshHeight: int,
        coordinates: Any,
        offsets: Any,
        offsetTrans: Transform,
        *rest: Any,
    ) -> None:
        """Draw a mesh of quadrilaterals."""
        mesh = meshWidth, meshHeight, coordinates, offsets
        self._agg.draw_quad_mesh(gc, master_transform, *mesh, offsetTrans, *rest)
        if self._as_pixels("draw_quad_mesh", gc, master_transform, *mesh, offsetTrans, *rest):
            return
        master, offset = self._scaled(master_transform), self._scaled(offsetTrans)
        self._pdf.draw_quad_mesh(self._context(gc), master, *mesh, offset, *rest)

    def draw_gouraud_triangles(self, gc: _Context, triangles_array: Any, colors_array: Any, transform: Any) -> None:
        """Draw shaded triangles."""
        self._agg.draw_gouraud_triangles(gc, triangles_array, colors_array, transform)
        if not self._as_pixels("draw_gouraud_triangles", gc, triangles_array, colors_array, transform):
            scaled = transform + self._to_points
            self._pdf.draw_gouraud_triangles(self._context(gc), triangles_array, colors_array, scaled)

    def draw_image(self, gc: _Context, x: float, y: float, im: Any, transform: Any = None) -> None:
        """Draw a picture."""
        self._agg.draw_image(gc, x, y, im)
        if not self._as_pixels("draw_image", gc, x, y, im):
            self._pdf.draw_image(self._context(gc), x * self._scale, y * self._scale, im)

    def draw_text(
        self,
        gc: _Context,
        x: float,
        y: float,
        s: str,
        prop: FontProperties,
        angle: float,
        ismath: Any = False,
        mtext: Any = None,
    ) -> None:
        """Draw a text."""
        what = s, prop, angle, ismath, mtext
        self._agg.draw_text(gc, x, y, *what)
        if not self._as_pixels("draw_text", gc, x, y, *what):  # the PDF counts y from below
            self._pdf.draw_text(self._context(gc), x * self._scale, (self.height - y) * self._scale, *what)

    def start_rasterizing(self) -> None:
        """Begin with artists that are pixels in the PDF."""
        self._pixels = RendererAgg(self.width, self.height, self.dpi)

    def stop_rasterizing(self) -> None:
        """End with them: give the PDF the part of the picture that has something."""
        if self._pixels is None:
            return
        picture, self._pixels = np.asarray(self._pixels.buffer_rgba()), None
        rows, columns = (np.flatnonzero(picture[..., 3].any(axis=axis)) for axis in (1, 0))
        if not rows.size:
            return
        part = picture[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1][::-1]
        left, bottom = columns[0] * self._scale, (len(picture) - 1 - rows[-1]) * self._scale
        self._pdf.draw_image(self._pdf.new_gc(), left, bottom, part)

    def _as_pixels(self, way: str, *arguments: Any, **options: Any) -> bool:
        """Draw with the renderer of artists that are pixels in the PDF; return False if this is none of them."""
        if self._pixels is None:
            return False
        draw: Callable[..., None] = getattr(self._pixels, way)
        draw(*arguments, **options)
        return True

    def _scaled(self, transform: Any) -> Affine2D:
        """Return an affine transform, which artists may give as a matrix, in points."""
        matrix = transform.get_matrix() if isinstance(transform, Transform) else transform
        return Affine2D(self._to_points.get_matrix() @ np.asarray(matrix))

    def _context(self, gc: _Context) -> _Context:
        """Return colours, lines and clipping for the PDF."""
        found: Any = self._pdf.new_gc()
        found.copy_properties(gc)
        clip: Any = gc.get_clip_path()
        rectangle, (path, transform) = gc.get_clip_rectangle(), clip
        if rectangle is not None:
            found.set_clip_rectangle(TransformedBbox(rectangle, self._to_points))
        if path is not None:
            found.set_clip_path(TransformedPath(path, transform + self._to_points))
        return found
