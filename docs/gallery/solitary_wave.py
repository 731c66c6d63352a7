"""A solitary wave in a chain

The first bead of an elastic chain of brass is given a velocity of 1 m/s. After a few beads the pulse keeps its shape:
a solitary wave, some five beads long. Forces of single contacts and the map of all of them show it.
"""

from granwave.analysis import Result
from granwave.analysis.figures.style import BLUE, ORANGE, new_figure, style
from granwave.workflows import load_case, run_case

case = load_case("elastic-impact", {"packing.size": 60, "run.end_time": 9e-4, "output.history": 2000})
outcome = run_case(case, "run", force=True, figures=False)

with Result("run") as result:
    time, force = result["chain/time"], result["chain/contact_force"]  # s; N, (n_times, n_contacts)

with style():
    figure = new_figure(2.6, width=6.4)
    left, right = figure.subplots(1, 2)
    for contact in range(5, 50, 10):
        left.plot(time * 1e6, force[:, contact], color=BLUE if contact % 20 == 5 else ORANGE, label=f"{contact + 1}")
    left.set(xlabel="time (us)", ylabel="contact force (N)", title="contacts 6, 16, 26, 36, 46")
    picture = right.pcolormesh(range(1, force.shape[1] + 1), time * 1e6, force, cmap="viridis", rasterized=True)
    right.set(xlabel="contact", ylabel="time (us)")
    figure.colorbar(picture, label="force (N)")
    figure.savefig("picture.png", dpi=150)

first, last = (time[force[:, contact].argmax()] for contact in (20, 45))
print(f"peak force in contact 30   {force[:, 29].max():.2f} N")
print(f"speed of the wave          {25 * case.packing.diameter / (last - first):.0f} m/s")
