// SPDX-License-Identifier: GPL-2.0-only
#include "compute_gran_hysteretic_sums.h"

#include "atom.h"
#include "error.h"
#include "fix_wall_gran_hysteretic.h"
#include "memory.h"
#include "modify.h"
#include "pair_gran_hysteretic.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

ComputeGranHystereticSums::ComputeGranHystereticSums(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg)
{
  if (narg != 3) error->all(FLERR, "Illegal compute {}: it takes no arguments", style);
  peratom_flag = 1;
  size_peratom_cols = 3;
}

ComputeGranHystereticSums::~ComputeGranHystereticSums() { memory->destroy(array_atom); }

void ComputeGranHystereticSums::compute_peratom()
{
  invoked_peratom = update->ntimestep;
  const int nlocal = atom->nlocal;
  if (atom->nmax > nmax) {
    memory->destroy(array_atom);
    nmax = atom->nmax;
    memory->create(array_atom, nmax, 3, "gran/hysteretic/sums:array_atom");
  }
  for (int i = 0; i < nlocal; i++) std::fill_n(array_atom[i], 3, 0.0);
  pair->for_each_dent([&](const PairGranHysteretic::Report &report) {
    if (report.force <= 0.0) return;
    for (int d = 0; d < 3; d++) {
      const double size = std::fabs(report.on_first[d]);
      array_atom[report.i][d] += size;
      if (report.j >= 0 && report.j < nlocal) array_atom[report.j][d] += size;
    }
  });
  for (const auto *fix : modify->get_fix_list())
    if (const auto *wall = dynamic_cast<const FixWallGranHysteretic *>(fix))
      for (int i = 0; i < nlocal; i++) wall->add_magnitudes(i, array_atom[i]);
  for (int i = 0; i < nlocal; i++)
    if (!(atom->mask[i] & groupbit)) std::fill_n(array_atom[i], 3, 0.0);
}

double ComputeGranHystereticSums::memory_usage() { return double(nmax) * 3 * sizeof(double); }
