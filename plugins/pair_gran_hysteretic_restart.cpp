/* Pair style gran/hysteretic: its settings and coefficients in restart files. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"

#include <algorithm>
#include <iterator>

using namespace LAMMPS_NS;
using granwave::Law;
using granwave::LawArguments;
using granwave::Material;

namespace {

// A file where all laws have the default constants is of the first format, and so readable by every version.
enum { DEFAULT_CONSTANTS = 1, OWN_CONSTANTS = 2 };
constexpr int N_BASIC = 11, N_CONSTANTS = std::size(granwave::LAW_CONSTANTS), N_STORED = N_BASIC + N_CONSTANTS;

int stored(int format) { return format == DEFAULT_CONSTANTS ? N_BASIC : N_STORED; }

void store(const LawArguments &a, double *v)
{
  const Material second = a.second.value_or(Material{0, 0, 0});
  const double values[N_BASIC] = {double(a.law), a.first.youngs_modulus, a.first.poisson_ratio, a.first.yield_strength,
                                  double(a.second.has_value()), second.youngs_modulus, second.poisson_ratio,
                                  second.yield_strength, double(a.variant), a.yield_factor, a.beta};
  std::copy_n(values, N_BASIC, v);
  for (int k = 0; k < N_CONSTANTS; k++) v[N_BASIC + k] = a.constants.*granwave::LAW_CONSTANTS[k].second;
}

LawArguments recall(const double *v, int format)
{
  LawArguments a;
  a.law = static_cast<Law>(int(v[0]));
  a.first = {v[1], v[2], v[3]};
  if (v[4] != 0.0) a.second = Material{v[5], v[6], v[7]};
  a.variant = static_cast<granwave::Variant>(int(v[8]));
  a.yield_factor = v[9];
  a.beta = v[10];
  for (int k = 0; k < N_CONSTANTS && format == OWN_CONSTANTS; k++)
    a.constants.*granwave::LAW_CONSTANTS[k].second = v[N_BASIC + k];
  return a;
}

}    // namespace

void PairGranHysteretic::write_restart_settings(FILE *fp)
{
  restart_format = DEFAULT_CONSTANTS;
  for (const LawArguments &args : given)
    if (args.constants != granwave::LawConstants()) restart_format = OWN_CONSTANTS;
  fwrite(&restart_format, sizeof(int), 1, fp);
  fwrite(&gap, sizeof(double), 1, fp);
}

void PairGranHysteretic::read_restart_settings(FILE *fp)
{
  if (comm->me == 0) {
    utils::sfread(FLERR, &restart_format, sizeof(int), 1, fp, nullptr, error);
    utils::sfread(FLERR, &gap, sizeof(double), 1, fp, nullptr, error);
  }
  MPI_Bcast(&restart_format, 1, MPI_INT, 0, world);
  MPI_Bcast(&gap, 1, MPI_DOUBLE, 0, world);
  if (restart_format != DEFAULT_CONSTANTS && restart_format != OWN_CONSTANTS)
    error->all(FLERR, "Restart file holds format {} of pair style gran/hysteretic; this version reads formats {} and {}",
               restart_format, int(DEFAULT_CONSTANTS), int(OWN_CONSTANTS));
}

void PairGranHysteretic::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  double values[N_STORED] = {};
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      fwrite(&setflag[i][j], sizeof(int), 1, fp);
      store(given[i * (atom_types + 1) + j], values);
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
      given[i * (atom_types + 1) + j] = recall(values, restart_format);
    }
}
