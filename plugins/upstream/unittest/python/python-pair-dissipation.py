"""Energy that contacts take: compute pair/dissipation/local with the granular pair styles."""

import os
import unittest

from lammps import lammps

CLASSIC = [
    "gran/hooke 1e6 NULL 1000 NULL 0.3 1",
    "gran/hooke/history 1e6 NULL 100 NULL 0.3 1",
    "gran/hertz/history 1e9 NULL 1e5 NULL 0.3 1",
]
GRANULAR = [
    "hertz/material 1e9 0.7 0.3 tangential mindlin NULL 1 0.3 damping tsuji",
    "jkr 1e9 1 0.3 1.0 tangential mindlin NULL 1 0.3",
    "hooke 1e6 50 tangential linear_history 3e5 1 0.3 damping mass_velocity",
]
RESISTANCES = " rolling sds 1e5 1 0.3 twisting marshall"
STYLES = [(style, "") for style in CLASSIC]
STYLES += [("granular", model + RESISTANCES) for model in GRANULAR]

IMPACT = """
units si
atom_style sphere
atom_modify map array
comm_modify vel yes
newton {newton}
boundary f f f
region b block -0.02 0.02 -0.02 0.02 -0.02 0.02
create_box 1 b
create_atoms 1 single 0 0 0
create_atoms 1 single 0.0091 0 0
set atom 1 diameter 0.010 density 7800
set atom 2 diameter 0.008 density 7800
set atom 1 omega 10 40 -80
group second id 2
velocity second set -1 0.7 0.2
"""
LOOSE = """
units si
atom_style sphere
atom_modify map array
comm_modify vel yes
newton {newton}
region b block 0 0.4 0 0.4 0 0.4
create_box 1 b
lattice sc 0.1
create_atoms 1 box
variable d atom 0.08*(1+0.2*(id%5)/5)
set atom * diameter v_d
set type 1 density 2000
set atom * omega 3 -2 5
velocity all create 1 4711 loop geom
velocity all scale 3e23
"""
MOTION = """
neighbor 0.002 bin
fix 1 all nve/sphere
compute ke all ke
compute er all erotate/sphere
timestep {step}
"""
COMPUTE = """
compute d all pair/dissipation/local tag1 tag2 energy energy/normal energy/tangential &
  energy/rolling energy/twisting
thermo_style custom step c_d[1]
"""


class PairDissipation(unittest.TestCase):
    """Impacts of two spheres and a gas of 64."""

    def setUp(self):
        self.lmp = None

    def tearDown(self):
        if self.lmp:
            self.lmp.close()

    def start(self, bodies, style, coeff, step, newton="on", compute=True):
        """Start LAMMPS, and return the kinetic energy."""
        if self.lmp:
            self.lmp.close()
        self.lmp = lammps(cmdargs=["-log", "none", "-screen", "none"])
        plugin = os.environ.get("PAIR_DISSIPATION_PLUGIN")
        if plugin:
            self.lmp.command("plugin load " + plugin)
        self.lmp.commands_string(bodies.format(newton=newton))
        self.lmp.command("pair_style " + style)
        self.lmp.command("pair_coeff * * " + coeff)
        self.lmp.commands_string(MOTION.format(step=step))
        if compute:
            self.lmp.commands_string(COMPUTE)
        self.lmp.command("run 0")
        return self.kinetic_energy()

    def kinetic_energy(self):
        """Return the kinetic energy of translation and rotation."""
        return self.lmp.extract_compute("ke", 0, 0) + self.lmp.extract_compute("er", 0, 0)

    def energies(self):
        """Return the energy that all contacts took, and its four channels."""
        vector = self.lmp.extract_compute("d", 0, 1)
        return [vector[k] for k in range(5)]

    def rows(self):
        """Return the rows of the open contacts."""
        rows = self.lmp.numpy.extract_compute("d", 2, 2)
        return [] if rows is None else rows.tolist()

    def test_impact(self):
        """The energy of an impact is the loss of the two spheres, to rounding errors."""
        for style, coeff in STYLES:
            for newton in ("on", "off"):
                with self.subTest(style=style, coeff=coeff, newton=newton):
                    before = self.start(IMPACT, style, coeff, 1e-7, newton)
                    self.lmp.command("run 6000")
                    lost = before - self.kinetic_energy()
                    energies = self.energies()
                    self.assertEqual(self.rows(), [])
                    self.assertGreater(lost, 0.03 * before)
                    self.assertAlmostEqual(energies[0], lost, delta=1e-12 * before)
                    self.assertAlmostEqual(sum(energies[1:]), energies[0], delta=1e-12 * before)

    def test_contact(self):
        """The only contact holds the energy, stored and dissipated."""
        before = self.start(IMPACT, "granular", GRANULAR[0] + RESISTANCES, 1e-7)
        self.lmp.command("run 1800")
        self.assertEqual(len(self.rows()), 1)
        row = self.rows()[0]
        self.assertEqual(sorted(row[:2]), [1.0, 2.0])
        energies = self.energies()
        self.assertGreater(energies[0], 0.3 * before)
        for value, expected in zip(row[2:], energies, strict=True):
            self.assertAlmostEqual(value, expected, delta=1e-14 * before)

    def test_order(self):
        """Inside a contact the difference falls with the square of the timestep."""
        differences = []
        for step, count in ((8e-7, 200), (4e-7, 400)):
            before = self.start(IMPACT, CLASSIC[2], "", step)
            self.lmp.command(f"run {count}")
            self.assertEqual(len(self.rows()), 1)
            lost = before - self.kinetic_energy()
            differences.append(abs(self.energies()[0] - lost) / before)
        self.assertLess(differences[0], 1e-3)
        self.assertAlmostEqual(differences[0] / differences[1], 4.0, delta=0.4)

    def test_reneighboring(self):
        """Records stay with their contacts as spheres migrate and neighbor lists are rebuilt."""
        for newton in ("on", "off"):
            before = self.start(LOOSE, CLASSIC[2].replace("1e9", "1e6"), "", 2e-6, newton)
            self.lmp.command("run 2500")
            self.lmp.command("run 2500")
            lost = before - self.kinetic_energy()
            self.assertGreater(lost, 0.05 * before)
            self.assertAlmostEqual(self.energies()[0], lost, delta=1e-6 * before)

    def test_trajectory(self):
        """The compute does not change the motion."""
        self.start(IMPACT, CLASSIC[2], "", 1e-7, compute=False)
        self.lmp.command("run 3000")
        alone = self.kinetic_energy()
        self.start(IMPACT, CLASSIC[2], "", 1e-7)
        self.lmp.command("run 3000")
        self.assertEqual(self.kinetic_energy(), alone)

    def test_errors(self):
        """Unknown values and pair styles without tangential forces are errors."""
        self.start(IMPACT, CLASSIC[2], "", 1e-7, compute=False)
        with self.assertRaisesRegex(Exception, "Unknown compute pair/dissipation/local keyword"):
            self.lmp.command("compute d all pair/dissipation/local heat")
        self.lmp.command("compute d all pair/dissipation/local energy")
        self.lmp.command("pair_style zero 0.02")
        self.lmp.command("pair_coeff * *")
        with self.assertRaisesRegex(Exception, "requires one granular pair style"):
            self.lmp.command("run 0")


if __name__ == "__main__":
    unittest.main()
