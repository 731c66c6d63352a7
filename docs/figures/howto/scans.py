"""Coefficient of restitution against velocity, of a built-in scan."""

from page_figures import save

import granwave as gw

scan = gw.scan("restitution", jobs=2)
save(scan.figure("restitution_vs_load_velocity"), "restitution")
