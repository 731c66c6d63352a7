"""Share of the energy that is dissipated beyond a distance, in packings of three sizes."""

from page_figures import save

import granwave as gw

scan = gw.scan("sizes.toml", jobs=2)
save(scan[3].figure("plastic_zone_size"), "plastic_zone_size")
