// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: settings and coefficients in restart files. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"

#include <algorithm>
#include <iterator>

using namespace LAMMPS_NS;
using granwave::LawArguments;
using granwave::Material;

namespace {

// Each format extends the previous one. A file has the lowest format that contains all features in use, and is readable by
// every version that supports this format.
enum { DEFAULT_CONSTANTS = 1, OWN_CONSTANTS = 2, FRICTION = 3, EXTRA_HISTORY = 4, POWER = 5 };    // 3 also for initial dents
constexpr int N_BASIC = 11, N_CONSTANTS = std::size(granwave::LAW_CONSTANTS), N_OWN = N_BASIC + N_CONSTANTS,
              N_FRICTION = N_OWN + 2, N_STORED = N_FRICTION + 2;

int stored(int format)
{
  if (format == DEFAULT_CONSTANTS) return N_BASIC;
  return format == OWN_CONSTANTS ? N_OWN : format == POWER ? N_STORED : N_FRICTION;
}

void store(const LawArguments &a, double *v)
{
  const Material second = a.second.value_or(Material{0, 0, 0});
  const double values[N_BASIC] = {double(a.law - granwave::law_table().data()),
                                  a.first.youngs_modulus,
                                  a.first.poisson_ratio,
                                  a.first.yield_strength,
                                  double(a.second.has_value()),
                                  second.youngs_modulus,
                                  second.poisson_ratio,
                                  second.yield_strength,
                                  double(a.options.variant),
                                  a.options.yield_factor,
                                  a.options.beta};
  std::copy_n(values, N_BASIC, v);
  for (int k = 0; k < N_CONSTANTS; k++) v[N_BASIC + k] = a.options.constants.*granwave::LAW_CONSTANTS[k].second;
  v[N_OWN] = a.friction;
  v[N_OWN + 1] = double(a.tangential);
  v[N_FRICTION] = a.options.constant;
  v[N_FRICTION + 1] = a.options.exponent;
}

LawArguments recall(const double *v, int format)
{
  LawArguments a;
  a.law = &granwave::law_table()[int(v[0])];
  a.first = {v[1], v[2], v[3]};
  if (v[4] != 0.0) a.second = Material{v[5], v[6], v[7]};
  a.options.variant = static_cast<granwave::Variant>(int(v[8]));
  a.options.yield_factor = v[9];
  a.options.beta = v[10];
  for (int k = 0; k < N_CONSTANTS && format >= OWN_CONSTANTS; k++)
    a.options.constants.*granwave::LAW_CONSTANTS[k].second = v[N_BASIC + k];
  if (format >= FRICTION) {
    a.friction = v[N_OWN];
    a.tangential = static_cast<granwave::TangentialModel>(int(v[N_OWN + 1]));
  }
  if (format >= POWER) {
    a.options.constant = v[N_FRICTION];
    a.options.exponent = v[N_FRICTION + 1];
  }
  return a;
}

}    // namespace

void PairGranHysteretic::write_restart_settings(FILE *fp)
{
  restart_format = DEFAULT_CONSTANTS;
  for (const LawArguments &args : coefficients)
    if (args.options.constants != granwave::LawConstants()) restart_format = OWN_CONSTANTS;
  if (has_friction || has_initial_dents) restart_format = FRICTION;
  for (const LawArguments &args : coefficients)
    if (args.law->n_extra > 0) restart_format = EXTRA_HISTORY;
  for (const LawArguments &args : coefficients)
    if (args.law->is_power()) restart_format = POWER;
  fwrite(&restart_format, sizeof(int), 1, fp);
  fwrite(&gap, sizeof(double), 1, fp);
  const int extras[2] = {has_friction, has_initial_dents};
  if (restart_format >= FRICTION) fwrite(extras, sizeof(int), 2, fp);
}

void PairGranHysteretic::read_restart_settings(FILE *fp)
{
  if (comm->me == 0) {
    utils::sfread(FLERR, &restart_format, sizeof(int), 1, fp, nullptr, error);
    utils::sfread(FLERR, &gap, sizeof(double), 1, fp, nullptr, error);
  }
  MPI_Bcast(&restart_format, 1, MPI_INT, 0, world);
  MPI_Bcast(&gap, 1, MPI_DOUBLE, 0, world);
  if (restart_format < DEFAULT_CONSTANTS || restart_format > POWER)
    error->all(FLERR, "Restart file holds format {} of pair style gran/hysteretic; this version reads formats {} to {}",
               restart_format, int(DEFAULT_CONSTANTS), int(POWER));
  int extras[2] = {};
  if (restart_format >= FRICTION && comm->me == 0) utils::sfread(FLERR, extras, sizeof(int), 2, fp, nullptr, error);
  MPI_Bcast(extras, 2, MPI_INT, 0, world);
  has_friction = extras[0];
  has_initial_dents = extras[1];
}

void PairGranHysteretic::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  double values[N_STORED] = {};
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      fwrite(&setflag[i][j], sizeof(int), 1, fp);
      store(coefficients[i * (atom_types + 1) + j], values);
      if (setflag[i][j]) fwrite(values, sizeof(double), stored(restart_format), fp);
    }
}

void PairGranHysteretic::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  double values[N_STORED] = {};
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      if (comm->me == 0) utils::sfread(FLERR, &setflag[i][j], sizeof(int), 1, fp, nullptr, error);
      MPI_Bcast(&setflag[i][j], 1, MPI_INT, 0, world);
      if (!setflag[i][j]) continue;
      if (comm->me == 0) utils::sfread(FLERR, values, sizeof(double), stored(restart_format), fp, nullptr, error);
      MPI_Bcast(values, N_STORED, MPI_DOUBLE, 0, world);
      if (!(values[0] >= 0.0 && values[0] < granwave::law_table().size()))
        error->all(FLERR, "Restart file holds law number {} of pair style gran/hysteretic; this version knows {}: {}",
                   values[0], granwave::law_table().size(), granwave::law_names(", "));
      coefficients[i * (atom_types + 1) + j] = recall(values, restart_format);
    }
}
