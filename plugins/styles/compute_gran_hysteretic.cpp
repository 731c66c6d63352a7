// SPDX-License-Identifier: GPL-2.0-only
#include "compute_gran_hysteretic.h"

#include "error.h"
#include "fix_wall_gran_hysteretic.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "pair_gran_hysteretic.h"

using namespace LAMMPS_NS;
using namespace granwave;
using Report = PairGranHysteretic::Report;

ComputeGranHysteretic::ComputeGranHysteretic(LAMMPS *lmp, int narg, char **arg, int words, const char *expected) :
    Compute(lmp, narg, arg)
{
  if (narg != 3 + words) error->all(FLERR, "Illegal compute {}: {}", style, expected);
}

ComputeGranHysteretic::~ComputeGranHysteretic()
{
  memory->destroy(array_atom);
  delete[] vector;
}

/* Find the pair style, which the script may have replaced since the last run. */
void ComputeGranHysteretic::init()
{
  pair = PairGranHysteretic::find(force);
  if (!pair) error->all(FLERR, "Compute {} requires pair style {}", style, PairGranHysteretic::STYLE);
}

/* ---------------------------------------------------------------------- per sphere */

void ComputeGranHysteretic::start_atoms()
{
  ComputeGranHysteretic::init();
  invoked_peratom = update->ntimestep;
  if (atom->nmax > nmax) {
    memory->destroy(array_atom);
    nmax = atom->nmax;
    memory->create(array_atom, nmax, size_peratom_cols, "compute_gran_hysteretic:array_atom");
  }
  for (int i = 0; i < atom->nlocal; i++) std::fill_n(array_atom[i], size_peratom_cols, 0.0);
}

void ComputeGranHysteretic::finish_atoms()
{
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & groupbit)) std::fill_n(array_atom[i], size_peratom_cols, 0.0);
}

namespace {
enum {
  FORCE,
  PEAK_FORCE,
  PEAK_OVERLAP,
  DISSIPATED,
  YIELDED,
  COORDINATION,
  FIRST,
  PEAK,
  YIELD,
  ELASTIC,
  TANGENTIAL,
  FRICTIONAL,
  VISCOUS,
  N_ATOM
};
}    // namespace

ComputeGranHystereticAtom::ComputeGranHystereticAtom(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg)
{
  peratom_flag = 1;
  size_peratom_cols = N_ATOM;
}

void ComputeGranHystereticAtom::compute_peratom()
{
  start_atoms();
  const int nlocal = atom->nlocal;
  for (int i = 0; i < nlocal; i++) std::fill_n(array_atom[i] + FIRST, static_cast<int>(ELASTIC - FIRST), -1.0);
  const auto reach = [](double *row, double force, double time, double overlap, double first, double yield) {
    if (force > row[PEAK_FORCE]) row[PEAK] = time;
    row[PEAK_FORCE] = std::max(row[PEAK_FORCE], force);
    row[PEAK_OVERLAP] = std::max(row[PEAK_OVERLAP], overlap);
    earliest(row[FIRST], first);
    earliest(row[YIELD], yield);
  };
  const auto add = [&](int i, double share, const Report &report) {
    double *row = array_atom[i];
    const Dent &dent = report.dent;
    reach(row, report.peak_force, dent.time_peak, dent.peak, report.time_first, dent.time_yield);
    row[FORCE] = std::max(row[FORCE], report.force);
    row[DISSIPATED] += share * report.dissipated;
    row[ELASTIC] += 0.5 * report.elastic;
    row[TANGENTIAL] += 0.5 * report.tangential_elastic;
    row[FRICTIONAL] += 0.5 * report.frictional_loss;
    row[VISCOUS] += 0.5 * report.viscous_loss;
    row[YIELDED] += report.yielded;
    row[COORDINATION] += report.touches;
  };
  pair->for_each_dent([&](const Report &report) {
    add(report.i, report.share_i, report);
    if (report.j >= 0 && report.j < nlocal) add(report.j, 1.0 - report.share_i, report);
  });
  for (int i = 0; i < nlocal; i++) {
    double *row = array_atom[i];
    const ForgottenContacts sums = pair->forgotten(i);
    reach(row, sums.peak_force, sums.time_peak, sums.peak_overlap, sums.time_first, sums.time_yield);
    row[DISSIPATED] += sums.own_dissipated;
    row[FRICTIONAL] += 0.5 * sums.frictional_loss;
    row[VISCOUS] += 0.5 * sums.viscous_loss;
    row[YIELDED] += sums.yielded;
  }
  finish_atoms();
}

ComputeGranHystereticSums::ComputeGranHystereticSums(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg)
{
  peratom_flag = 1;
  size_peratom_cols = 3;
}

void ComputeGranHystereticSums::compute_peratom()
{
  start_atoms();
  const int nlocal = atom->nlocal;
  pair->for_each_dent([&](const Report &report) {
    if (report.force == 0.0) return;
    for (int d = 0; d < 3; d++) {
      const double size = std::fabs(report.on_first[d]);
      array_atom[report.i][d] += size;
      if (report.j >= 0 && report.j < nlocal) array_atom[report.j][d] += size;
    }
  });
  for (auto *fix : modify->get_fix_list())
    if (auto *wall = dynamic_cast<FixWallGranHysteretic *>(fix))
      for (int i = 0; i < nlocal; i++) wall->add_magnitudes(i, array_atom[i]);
  finish_atoms();
}

/* ---------------------------------------------------------------------- per contact */

constexpr int N_LOCAL = 20;

ComputeGranHystereticLocal::ComputeGranHystereticLocal(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg)
{
  local_flag = 1;
  size_local_cols = N_LOCAL;
}

void ComputeGranHystereticLocal::compute_local()
{
  ComputeGranHysteretic::init();
  invoked_local = update->ntimestep;
  values.clear();
  const auto append = [this](auto... numbers) {
    static_assert(sizeof...(numbers) == N_LOCAL);
    values.insert(values.end(), {double(numbers)...});
  };
  const int nlocal = atom->nlocal;
  pair->for_each_dent([&](const Report &report) {
    if (!(atom->mask[report.i] & groupbit)) return;
    if (report.j >= 0 && !(atom->mask[report.j] & groupbit)) return;
    // a shared pair is on both processors, a forgotten one with both spheres: the owner of the lower ID reports it
    if ((report.j < 0 || report.j >= nlocal) && report.tag_i > report.tag_j) return;
    const auto [lower, higher] = std::minmax(report.tag_i, report.tag_j);
    const double side = report.tag_i < report.tag_j ? 1.0 : -1.0;    // the force acts on the sphere with the lower ID
    const double *const f = report.tangential;
    const Dent &dent = report.dent;
    append(lower, higher, report.overlap, report.force, dent.peak, report.peak_force, report.elastic, report.dissipated,
           report.time_first, dent.time_peak, dent.time_yield, report.live, report.tangential_force,
           report.tangential_elastic, report.frictional_loss, report.initial, report.viscous_loss, side * f[0], side * f[1],
           side * f[2]);
  });
  size_local_rows = static_cast<int>(values.size() / N_LOCAL);
  rows.resize(size_local_rows);
  for (int k = 0; k < size_local_rows; k++) rows[k] = values.data() + static_cast<std::size_t>(k) * N_LOCAL;
  array_local = rows.data();
}

double ComputeGranHystereticLocal::memory_usage()
{
  return double(values.capacity()) * sizeof(double) + double(rows.capacity()) * sizeof(double *);
}

/* ---------------------------------------------------------------------- one contact */

constexpr int N_CONTACT = 8;

ComputeGranHystereticContact::ComputeGranHystereticContact(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg, 2, "expected the ids of two spheres")
{
  first = utils::tnumeric(FLERR, arg[3], false, lmp);
  second = utils::tnumeric(FLERR, arg[4], false, lmp);
  if (first == second) error->all(FLERR, "Illegal compute {}: sphere {} has no contact with itself", style, first);
  vector_flag = 1;
  size_vector = N_CONTACT;
  extvector = 0;
  vector = new double[N_CONTACT]();
}

void ComputeGranHystereticContact::compute_vector()
{
  ComputeGranHysteretic::init();
  invoked_vector = update->ntimestep;
  double mine[N_CONTACT + 1] = {};    // the last element counts the processors that have the pair
  pair->visit_pair(first, second, [&](const Report &report) {
    const double row[N_CONTACT + 1] = {report.overlap,         report.force,        report.dent.peak,
                                       report.elastic,         report.dissipated,   report.tangential_force,
                                       report.frictional_loss, report.viscous_loss, 1.0};
    std::copy_n(row, N_CONTACT + 1, mine);
  });
  double sum[N_CONTACT + 1];
  MPI_Allreduce(mine, sum, N_CONTACT + 1, MPI_DOUBLE, MPI_SUM, world);
  for (int k = 0; k < N_CONTACT; k++) vector[k] = sum[N_CONTACT] > 0.0 ? sum[k] / sum[N_CONTACT] : 0.0;
}

/* ---------------------------------------------------------------------- all contacts */

ComputeGranHystereticEnergy::ComputeGranHystereticEnergy(LAMMPS *lmp, int narg, char **arg) :
    ComputeGranHysteretic(lmp, narg, arg)
{
  scalar_flag = vector_flag = 1;
  extscalar = extvector = 0;    // sums over contacts, not normalized by the number of atoms
  size_vector = PairGranHysteretic::N_TOTALS;
  vector = new double[PairGranHysteretic::N_TOTALS]();
}

double ComputeGranHystereticEnergy::compute_scalar()
{
  invoked_scalar = update->ntimestep;
  sum_up();
  return scalar;
}

void ComputeGranHystereticEnergy::compute_vector()
{
  invoked_vector = update->ntimestep;
  sum_up();
}

void ComputeGranHystereticEnergy::sum_up()
{
  if (summed == update->ntimestep && update->whichflag != 0) return;    // positions may be changed between runs
  ComputeGranHysteretic::init();
  summed = update->ntimestep;
  constexpr int N = PairGranHysteretic::N_TOTALS;
  double mine[N + 1], sum[N + 1];
  mine[N] = pair->tally_totals();
  std::copy_n(pair->pvector, N, mine);
  MPI_Allreduce(mine, sum, N + 1, MPI_DOUBLE, MPI_SUM, world);
  std::copy_n(sum, N, vector);
  scalar = sum[N];
}
