"""Impact and waves in ordered granular packings, on LAMMPS.

import granwave as gw

run = gw.run("fcc-small", load__velocity=10)    # run a case and load it
scan = gw.scan("restitution", jobs=2)           # a scan
best = gw.design("plate-design.toml").best      # a search for the best packing
gw.load("fcc-small")                            # load existing results
gw.compare(["fcc-small", "hcp-small"])          # largest differences between runs
gw.export("fcc-small", "csv", layers=[1, 2])    # tables for other programs, or selected rows
gw.bands("precompressed-chain")                 # small waves: bands, modes, transmission
gw.infer("grains.csv", "infer.toml")            # contact forces from measured grains
gw.case("fcc-small", load__velocity=10)         # a case that is checked but not run
gw.contact_force("hertz", bodies, overlap)      # single contacts: force, energy ...
gw.measures, gw.theory                          # arrival, decay ...; Hertz's chain, impact
gw.Row, gw.Picture                              # for your own studies
"""

from granwave._version import __version__ as __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    # for editors; includes names of our extensions; a test compares them with these
    from granwave import measures, theory
    from granwave.extensions.design.python import Designs, design
    from granwave.extensions.inference.python import InferredForces, infer
    from granwave.extensions.inference.relaxation import stress_history
    from granwave.extensions.waves.python import bands, modes, transmission
    from granwave.workflows.python.api import (
        Case,
        Comparison,
        GranwaveError,
        InputError,
        MissingOutputError,
        OutputFormatError,
        Picture,
        Row,
        Run,
        RunError,
        ScanRuns,
        case,
        compare,
        contact_energy,
        contact_force,
        contact_overlap,
        contact_stiffness,
        contact_yield,
        export,
        load,
        run,
        scan,
        style,
    )

    __all__ = [
        "Case",
        "Comparison",
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
        "compare",
        "contact_energy",
        "contact_force",
        "contact_overlap",
        "contact_stiffness",
        "contact_yield",
        "design",
        "export",
        "infer",
        "load",
        "measures",
        "modes",
        "run",
        "scan",
        "stress_history",
        "style",
        "theory",
        "transmission",
    ]
else:
    _PACKAGES = ("analysis", "extensions", "lammps_inputs", "plugins", "workflows")
    _MODULES = ("measures", "theory")

    def __getattr__(name: str) -> object:
        # imported on demand: every command starts here, and most need neither pandas nor matplotlib
        import importlib

        if name in _PACKAGES or name in _MODULES:
            return importlib.import_module(f"granwave.{name}")
        if name.startswith("_") and name != "__all__":
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        api = importlib.import_module("granwave.workflows.python.api")
        if name == "__all__":
            return sorted([*api.public_names(), *_MODULES])
        return api.object_of(name)

    def __dir__() -> list[str]:
        return sorted([*globals(), *__getattr__("__all__"), *_PACKAGES])
