"""A solitary wave in a chain

The first bead of an elastic brass chain starts at 1 m/s. After a few beads the pulse keeps its
shape: it is a solitary wave, some five beads long. The left panel shows forces of single contacts,
the right panel all contacts.
"""

import matplotlib.pyplot as plt

import granwave as gw

changes = {"packing.size": 60, "run.end_time": 9e-4, "output.history": 2000}
run = gw.run("elastic-impact", changes, directory="run", force=True)
# s; N, (n_times, n_contacts)
time = run.chain.time.values
force = run.chain.contact_force.values

with gw.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.4, 2.6))
    for contact in range(5, 50, 10):
        left.plot(
            time * 1e6,
            force[:, contact],
            color="C0" if contact % 20 == 5 else "C1",
            label=f"{contact + 1}",
        )
    left.set(xlabel="time (µs)", ylabel="contact force (N)", title="contacts 6, 16, 26, 36, 46")
    picture = right.pcolormesh(
        range(1, force.shape[1] + 1), time * 1e6, force, cmap="viridis", rasterized=True
    )
    right.set(xlabel="contact", ylabel="time (µs)")
    figure.colorbar(picture, label="force (N)")
    figure.savefig("picture.png", dpi=150)

first, last = (time[force[:, contact].argmax()] for contact in (20, 45))
print(f"peak force in contact 30   {force[:, 29].max():.2f} N")
print(f"speed of the wave          {25 * run.case.packing.diameter / (last - first):.0f} m/s")
