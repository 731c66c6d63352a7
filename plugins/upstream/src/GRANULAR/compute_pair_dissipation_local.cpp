/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   Copyright (2003) Sandia Corporation.  Under the terms of Contract
   DE-AC04-94AL85000 with Sandia Corporation, the U.S. Government retains
   certain rights in this software.  This software is distributed under
   the GNU General Public License.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#include "compute_pair_dissipation_local.h"

#include "atom.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include <numeric>

using namespace LAMMPS_NS;

static constexpr int DELTA = 10000;
static constexpr int ALL = FixPairDissipation::NCHANNEL;
static constexpr const char *CHANNELS[] = {"normal", "tangential", "rolling", "twisting"};

/* ---------------------------------------------------------------------- */

ComputePairDissipationLocal::ComputePairDissipationLocal(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg), fix(nullptr), nmax(0), vlocal(nullptr), alocal(nullptr)
{
  if (narg < 4) utils::missing_cmd_args(FLERR, "compute pair/dissipation/local", error);

  for (int iarg = 3; iarg < narg; iarg++) {
    const std::string name = arg[iarg];
    if (name == "tag1") {
      values.push_back({TAG1, ALL});
    } else if (name == "tag2") {
      values.push_back({TAG2, ALL});
    } else if (name == "energy") {
      values.push_back({ENERGY, ALL});
    } else if (name == "rate") {
      values.push_back({RATE, ALL});
    } else {
      bool known = false;
      for (int ichannel = 0; ichannel < ALL; ichannel++) {
        if (name == std::string("energy/") + CHANNELS[ichannel]) {
          values.push_back({ENERGY, ichannel});
          known = true;
        } else if (name == std::string("rate/") + CHANNELS[ichannel]) {
          values.push_back({RATE, ichannel});
          known = true;
        }
      }
      if (!known)
        error->all(FLERR, iarg, "Unknown compute pair/dissipation/local keyword: {}", name);
    }
  }

  local_flag = 1;
  size_local_cols = (values.size() == 1) ? 0 : (int) values.size();
  vector_flag = 1;
  size_vector = 1 + ALL;
  extvector = 1;
  vector = new double[size_vector];

  // the fix integrates from now on, and is deleted with this compute

  id_fix = id + std::string("_PAIR_DISSIPATION");
  fix = dynamic_cast<FixPairDissipation *>(
      modify->add_fix(fmt::format("{} {} PAIR_DISSIPATION", id_fix, arg[1])));
}

/* ---------------------------------------------------------------------- */

ComputePairDissipationLocal::~ComputePairDissipationLocal()
{
  if (modify->get_fix_by_id(id_fix)) modify->delete_fix(id_fix);
  delete[] vector;
  memory->destroy(vlocal);
  memory->destroy(alocal);
}

/* ---------------------------------------------------------------------- */

void ComputePairDissipationLocal::init()
{
  fix = dynamic_cast<FixPairDissipation *>(modify->get_fix_by_id(id_fix));
  if (!fix)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {} of compute pair/dissipation/local {} does not exist", id_fix, id);
}

/* ----------------------------------------------------------------------
   energy taken from the group by all its contacts so far, in sum and by channel
------------------------------------------------------------------------- */

void ComputePairDissipationLocal::compute_vector()
{
  invoked_vector = update->ntimestep;
  MPI_Allreduce(fix->total, vector + 1, ALL, MPI_DOUBLE, MPI_SUM, world);
  vector[0] = std::accumulate(vector + 1, vector + 1 + ALL, 0.0);
}

/* ---------------------------------------------------------------------- */

void ComputePairDissipationLocal::compute_local()
{
  invoked_local = update->ntimestep;

  const int nlocal = atom->nlocal;
  int ncount = 0;
  for (int i = 0; i < nlocal; i++)
    for (const auto &contact : fix->contacts_of(i)) ncount += contact.owner;
  if (ncount > nmax) reallocate(ncount);
  size_local_rows = ncount;

  int row = 0;
  for (int i = 0; i < nlocal; i++) {
    for (const auto &contact : fix->contacts_of(i)) {
      if (!contact.owner) continue;
      double *out = (values.size() == 1) ? &vlocal[row] : alocal[row];
      for (const auto &value : values) *out++ = get(value, atom->tag[i], contact);
      row++;
    }
  }
}

/* ---------------------------------------------------------------------- */

double ComputePairDissipationLocal::get(const Value &value, tagint tag,
                                        const FixPairDissipation::Contact &contact) const
{
  if (value.quantity == TAG1) return tag;
  if (value.quantity == TAG2) return contact.partner;
  const double *from = (value.quantity == ENERGY) ? contact.energy : contact.rate;
  if (value.channel == ALL) return std::accumulate(from, from + ALL, 0.0);
  return from[value.channel];
}

/* ---------------------------------------------------------------------- */

void ComputePairDissipationLocal::reallocate(int n)
{
  while (nmax < n) nmax += DELTA;
  if (values.size() == 1) {
    memory->destroy(vlocal);
    memory->create(vlocal, nmax, "pair/dissipation/local:vector_local");
    vector_local = vlocal;
  } else {
    memory->destroy(alocal);
    memory->create(alocal, nmax, values.size(), "pair/dissipation/local:array_local");
    array_local = alocal;
  }
}

/* ---------------------------------------------------------------------- */

double ComputePairDissipationLocal::memory_usage()
{
  return (double) nmax * values.size() * sizeof(double);
}
