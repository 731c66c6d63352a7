"""Impact and waves in ordered granular packings, on LAMMPS.

import granwave as gw

run = gw.run("fcc-small", load__velocity=10)    # a case: run, and loaded
scan = gw.scan("restitution", jobs=2)           # a scan
best = gw.design("plate-design.toml").best      # a search for the best packing
gw.load("fcc-small")                            # what is there
gw.bands("precompressed-chain")                 # small waves: bands, modes, transmission
gw.infer("grains.csv", "infer.toml")            # contact forces from measured grains
gw.case("fcc-small", load__velocity=10)         # a case, checked and not run
gw.contact_force("hertz", bodies, overlap)      # single contacts: force, stiffness, energy, overlap
gw.measures, gw.theory                          # arrival, peaks, width, decay ...; Hertz's chain and impact
gw.Row, gw.Picture                              # of studies of one's own
"""

from granwave._version import __version__ as __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from granwave import measures, theory
    from granwave.workflows.python.api import (
        Case,
        Designs,
        GranwaveError,
        InferredForces,
        InputError,
        MissingOutputError,
        OutputFormatError,
        Picture,
        Row,
        Run,
        RunError,
        ScanRuns,
        bands,
        case,
        contact_energy,
        contact_force,
        contact_overlap,
        contact_stiffness,
        contact_yield,
        design,
        infer,
        load,
        modes,
        run,
        scan,
        style,
        transmission,
    )

_PACKAGES = ("analysis", "lammps_inputs", "plugins", "workflows")
_MODULES = ("measures", "theory")

__all__ = [
    "Case",
    "Designs",
    "GranwaveError",
    "InferredForces",
    "InputError",
    "MissingOutputError",
    "OutputFormatError",
    "Picture",
    "Row",
    "Run",
    "RunError",
    "ScanRuns",
    "bands",
    "case",
    "contact_energy",
    "contact_force",
    "contact_overlap",
    "contact_stiffness",
    "contact_yield",
    "design",
    "infer",
    "load",
    "measures",
    "modes",
    "run",
    "scan",
    "style",
    "theory",
    "transmission",
]


if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        # imported on demand: every command starts here, and most need neither numpy nor matplotlib
        if name not in __all__ and name not in _PACKAGES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        import importlib

        if name in _PACKAGES or name in _MODULES:
            return importlib.import_module(f"granwave.{name}")
        return getattr(importlib.import_module("granwave.workflows.python.api"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__, *_PACKAGES])
