// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: settings and coefficients in restart files. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"
#include "restart_state.h"

#include <algorithm>
#include <cmath>
#include <iterator>

using namespace LAMMPS_NS;
using granwave::LawArguments;
using granwave::Material;

namespace {

// Each format extends the previous one. Files are written in the last one; those before it had no checksums, and all forgotten
// dents on record.
enum {    // format 3 also for initial dents
  DEFAULT_CONSTANTS = 1,
  OWN_CONSTANTS = 2,
  FRICTION = 3,
  EXTRA_HISTORY = 4,
  POWER = 5,
  LOSS = 6,
  CHECKSUMS = 7
};
enum { GAP, HAS_FRICTION, HAS_INITIAL_DENTS, LISTS_FORGOTTEN, SUM, N_SETTINGS };    // of format 7
constexpr int N_BASIC = 11, N_CONSTANTS = std::size(granwave::LAW_CONSTANTS), N_OWN = N_BASIC + N_CONSTANTS,
              N_FRICTION = N_OWN + 2, N_POWER = N_FRICTION + 2, N_LOSS = N_POWER + 2,
              N_STORED = N_LOSS + 1;    // the checksum comes last

int stored(int format)
{
  if (format >= POWER) return format == POWER ? N_POWER : format == LOSS ? N_LOSS : N_STORED;
  return format == DEFAULT_CONSTANTS ? N_BASIC : format == OWN_CONSTANTS ? N_OWN : N_FRICTION;
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
  v[N_POWER] = double(a.loss.kind);
  v[N_POWER + 1] = a.loss.value;
  v[N_LOSS] = granwave::checksum(v, N_LOSS);
}

/* True if these numbers can be those of a law. */

bool is_sound(const double *v, int format)
{
  const auto is_material = [](const double *m) { return m[0] > 0.0 && m[1] > -1.0 && m[1] <= 0.5 && m[2] > 0.0; };
  return granwave::is_whole(v[0], 0, granwave::law_table().size() - 1.0) && granwave::is_whole(v[4], 0, 1) &&
         granwave::is_whole(v[8], 0, 1) && is_material(v + 1) && (v[4] == 0.0 || is_material(v + 5)) &&
         std::all_of(v + 8, v + N_LOSS, [](double value) { return std::isfinite(value); }) &&
         (format < FRICTION || (v[N_OWN] >= 0.0 && granwave::is_whole(v[N_OWN + 1], 0, 1))) &&
         (format < LOSS || (granwave::is_whole(v[N_POWER], 0, 2) && v[N_POWER + 1] >= 0.0)) &&
         (format < CHECKSUMS || v[N_LOSS] == granwave::checksum(v, N_LOSS));
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
  if (format >= LOSS) a.loss = {static_cast<granwave::LossKind>(int(v[N_POWER])), v[N_POWER + 1]};
  return a;
}

}    // namespace

void PairGranHysteretic::write_restart_settings(FILE *fp)
{
  restart_format = CHECKSUMS;
  double settings[N_SETTINGS] = {gap, double(has_friction), double(has_initial_dents), double(lists_forgotten)};
  settings[SUM] = granwave::checksum(settings, SUM);
  fwrite(&restart_format, sizeof(int), 1, fp);
  fwrite(settings, sizeof(double), N_SETTINGS, fp);
}

void PairGranHysteretic::read_restart_settings(FILE *fp)
{
  if (comm->me == 0) utils::sfread(FLERR, &restart_format, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&restart_format, 1, MPI_INT, 0, world);
  if (restart_format < DEFAULT_CONSTANTS || restart_format > CHECKSUMS)
    error->all(FLERR, "Restart file holds format {} of pair style gran/hysteretic; this version reads formats {} to {}",
               restart_format, int(DEFAULT_CONSTANTS), int(CHECKSUMS));
  const bool old = restart_format < CHECKSUMS;
  double settings[N_SETTINGS] = {0.0, 0.0, 0.0, 1.0};
  if (comm->me == 0) {
    int extras[2] = {};
    utils::sfread(FLERR, settings, sizeof(double), old ? 1 : N_SETTINGS, fp, nullptr, error);
    if (old && restart_format >= FRICTION) utils::sfread(FLERR, extras, sizeof(int), 2, fp, nullptr, error);
    if (old) std::copy_n(extras, 2, settings + HAS_FRICTION);
  }
  MPI_Bcast(settings, N_SETTINGS, MPI_DOUBLE, 0, world);
  from_restart = true;
  gap = settings[GAP];
  has_friction = settings[HAS_FRICTION] != 0.0;
  has_initial_dents = settings[HAS_INITIAL_DENTS] != 0.0;
  lists_forgotten = settings[LISTS_FORGOTTEN] != 0.0;
  if (!(gap > 0.0 && std::isfinite(gap)) || (!old && settings[SUM] != granwave::checksum(settings, SUM)))
    error->all(FLERR, "The restart file is damaged: the settings of pair style gran/hysteretic are none");
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
      const auto damaged = [&] {
        error->all(FLERR, "The restart file is damaged: the law of types {} and {} of pair style gran/hysteretic is none", i,
                   j);
      };
      if (setflag[i][j] != 0 && setflag[i][j] != 1) damaged();
      if (!setflag[i][j]) continue;
      if (comm->me == 0) utils::sfread(FLERR, values, sizeof(double), stored(restart_format), fp, nullptr, error);
      MPI_Bcast(values, N_STORED, MPI_DOUBLE, 0, world);
      if (!(values[0] >= 0.0 && values[0] < granwave::law_table().size()))
        error->all(FLERR, "Restart file holds law number {} of pair style gran/hysteretic; this version knows {}: {}",
                   values[0], granwave::law_table().size(), granwave::law_names(", "));
      if (!is_sound(values, restart_format)) damaged();
      coefficients[i * (atom_types + 1) + j] = recall(values, restart_format);
    }
}
