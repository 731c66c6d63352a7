"""Force on the plate in time, and peak reduction against the height of the packing."""

from page_figures import save

import granwave as gw

save(gw.run("plate.toml").figure("target"), "target")
scan = gw.scan("heights.toml", jobs=2)
axes = scan.figure("peak_reduction_vs_packing_size")
axes.set_ylabel("Peak reduction")
save(axes, "heights")
