// SPDX-License-Identifier: GPL-2.0-only
// Headers of all styles, each with their names in a block at its top. Read twice by add_styles.cpp, so without a guard.

#include "compute_gran_hysteretic.h"
#include "fix_gran_cylinder.h"
#include "fix_gran_damping.h"
#include "fix_gran_hysteretic_history.h"
#include "fix_gran_load.h"
#include "fix_gran_nve.h"
#include "fix_gran_nve_sphere.h"
#include "fix_gran_timestep.h"
#include "fix_wall_gran_hysteretic.h"
#include "gran_dents.h"
#include "pair_gran_hysteretic.h"
#ifdef GRANWAVE_KOKKOS
#include "../kokkos/pair_gran_hysteretic_kokkos.h"
#endif
