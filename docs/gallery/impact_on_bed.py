"""Impact of a steel sphere on a poured bed

Steel spheres of 20 mm hit a bed of 150 soft glass spheres, poured and at rest under gravity, which
also acts on the steel sphere. They start near the middle of a box that is five grains wide. Within
40 ms they reach depths of 6 and 9 mm. These depths are compared with a formula for the final depth
in dry grains by Ambroso, Santore, Abate and Durian (Phys. Rev. E 71 (2005) 051305),
d = (0.14/mu) (rho/rho_bed)^(1/2) D^(2/3) H^(1/3), with the total drop distance H = v^2/2g + d, the
density of the bed rho_bed and the tangent mu of its angle of repose. The depths are smaller than
the formula by factors of 2.5 and 4. The formula holds for spheres in deep and wide beds of much
smaller grains. Here the grains are half as large as the sphere, and the box is only 2.5 sphere
diameters wide; the influence of each was not tested. In the larger beds on the page of poured
packings, the depths are 0.44 to 0.82 times the formula.

The largest force is the force of the first collision with a grain. It is almost proportional to the
power 6/5 of the velocity, as for a collision of elastic spheres. It is far above the inertial
drag m v^2/d1, d1 = (0.25/mu) (rho/rho_bed) D, of Katsuragi and Durian (Phys. Rev. E 87 (2013)
052208) for grains much smaller than the sphere.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

REPOSE = np.tan(np.radians(22.0))  # angle of repose of spheres with this friction
GRAVITY = 9.81
DIAMETER = 0.02
bed = {
    "packing.grains": 150,
    "packing.box": [0.05, 0.05],
    "precompression.strikers": True,
    "run.end_time": 0.04,
}
speeds = [0.5, 2.0]
depths = []
forces = []
for speed in speeds:
    run = gw.run(
        "poured-small",
        {**bed, "striker.1.velocity": [0.0, 0.0, speed]},
        directory="run",
        force=True,
        figures=False,
    )
    time = run.energies.index.to_numpy()
    velocity = run.energies["struck_velocity"].to_numpy()
    depth = np.concatenate([[0.0], np.cumsum(np.diff(time) * (velocity[1:] + velocity[:-1]) / 2)])
    mass = run.spheres["mass"].iloc[-1]
    depths.append(depth.max())
    forces.append(-mass * np.gradient(velocity, time).min())

density = 0.58 * 2500  # density of the bed
height = np.array(speeds) ** 2 / (2 * GRAVITY) + depths
formula = 0.14 / REPOSE * np.sqrt(7850 / density) * DIAMETER ** (2 / 3) * height ** (1 / 3)
drag = mass * np.array(speeds) ** 2 / (0.25 / REPOSE * 7850 / density * DIAMETER)
with gw.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6, 2.6))
    left.loglog(speeds, 1e3 * np.array(depths), "o", label="runs")
    left.loglog(speeds, 1e3 * formula, label="Ambroso et al. 2005")
    left.set(xlabel="impact speed (m/s)", ylabel="depth (mm)")
    left.legend()
    right.loglog(speeds, forces, "o")
    power, level = np.polyfit(np.log(speeds), np.log(forces), 1)
    right.loglog(speeds, np.exp(level) * np.array(speeds) ** power, label=f"power {power:.2f}")
    right.loglog(speeds, forces[0] * (np.array(speeds) / speeds[0]) ** 1.2, ":", label="power 6/5")
    right.loglog(speeds, drag, "--", label="inertial drag")
    right.set(xlabel="impact speed (m/s)", ylabel="largest force on the sphere (N)")
    right.legend()
    for axes, values in ((left, [2, 5, 10, 20, 40]), (right, [0.03, 0.1, 0.3, 1, 3, 10, 30])):
        axes.set_xticks(speeds, [f"{speed:g}" for speed in speeds])
        axes.set_yticks(values, [f"{value}" for value in values])
        axes.xaxis.set_minor_formatter("")
        axes.yaxis.set_minor_formatter("")
    figure.savefig("picture.png", dpi=150)

for speed, depth, published, force in zip(speeds, depths, formula, forces, strict=True):
    depths_in_mm = f"{1e3 * depth:5.1f} mm, formula {1e3 * published:5.1f} mm"
    print(f"{speed:5.2f} m/s   {depths_in_mm}   {force:6.1f} N")
