"""Contacts as lines, their forces, a wave along a chain, forces and energies by depth."""

from page_figures import save

import granwave as gw

bed = gw.run("poured-small")
for name in ("contact_network", "force_distribution"):
    save(bed.figure(name), name)
save(
    gw.run("elastic-impact", packing__size=40, run__end_time=7e-4).figure("line_diagram"),
    "line_diagram",
)
packing = gw.run(
    "fcc-small",
    packing__size=[16, 16, 8],
    run={"end_time": 1.2e-4, "frames": 120},
    output__contact_forces=True,
    figures=False,
)
save(packing.figure("force_at_depths", depths=[0.01, 0.025, 0.04]), "force_at_depths")
save(gw.run("composite-chain", figures=False).figure("energy_by_region"), "energy_by_region")
