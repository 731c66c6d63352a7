"""Labels of axes in the units of the chain: E* R*^2 (force), tau (time; thesis 2.24) and R* (length)."""

FORCE = r"Force $F/E^*R^{*2}$"
PEAK_FORCE = r"Peak force $F/E^*R^{*2}$"
VELOCITY = r"Velocity $v\,\tau/R^*$"
TIME = r"Time $t/\tau$"
PLACE = r"Distance $x/R^*$"
