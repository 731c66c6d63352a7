"""Peak forces in the packing of the case."""

from page_figures import save

import granwave as gw

save(gw.run("mine.toml").figure("packing_3d"), "packing_3d")
