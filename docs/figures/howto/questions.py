"""Force on a plate with the packing and without it."""

from page_figures import save

import granwave as gw

save(gw.run("protected-target").figure("target"), "target")
