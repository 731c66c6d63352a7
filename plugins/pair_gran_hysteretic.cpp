/* Pair style gran/hysteretic: settings and forces. */

#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "error.h"
#include "fix.h"
#include "fix_gran_hysteretic_history.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "simulated_time.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using granwave::ContactLaw;
using granwave::ContactScale;
using granwave::LawArguments;
using granwave::Turning;

PairGranHysteretic::PairGranHysteretic(LAMMPS *lmp) : Pair(lmp)
{
  restartinfo = 1;
  single_enable = 1;
  single_extra = N_SINGLE;
  svector = new double[N_SINGLE]();
  nextra = N_TOTALS;
  pvector = new double[N_TOTALS]();
  no_virial_fdotr_compute = 1;
  finitecutflag = 1;
  writedata = 0;
  centroidstressflag = CENTROID_SAME;
}

PairGranHysteretic::~PairGranHysteretic()
{
  delete[] svector;
  delete[] pvector;
  if (copymode) return;
  if (fix_history) {
    fix_history->pair = nullptr;
    if (modify && modify->get_fix_by_id(FixGranHystereticHistory::ID)) modify->delete_fix(FixGranHystereticHistory::ID);
  }
  if (allocated) {
    memory->destroy(setflag);
    memory->destroy(cutsq);
  }
}

void PairGranHysteretic::allocate()
{
  allocated = 1;
  atom_types = atom->ntypes;
  const int n = atom_types + 1;
  memory->create(setflag, n, n, "pair:setflag");
  for (int i = 0; i < n; i++) std::fill_n(setflag[i], n, 0);
  memory->create(cutsq, n, n, "pair:cutsq");
  laws.assign(n * n, ContactLaw());
  given.assign(n * n, LawArguments());
  largest_radius.assign(n, 0.0);
}

void PairGranHysteretic::settings(int narg, char **arg)
{
  if (narg != 1)
    error->all(FLERR, "Illegal pair_style gran/hysteretic: expected one argument, the gap beyond which a dent is "
                      "forgotten, found {}", narg);
  gap = utils::numeric(FLERR, arg[0], false, lmp);
  if (!(gap > 0.0) || !std::isfinite(gap))
    error->all(FLERR, "Illegal pair_style gran/hysteretic: the gap must be positive, found {}", arg[0]);
}

void PairGranHysteretic::coeff(int narg, char **arg)
{
  if (narg < 3) error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: expected I J law and its constants");
  if (!allocated) allocate();
  int ilo, ihi, jlo, jhi;
  utils::bounds(FLERR, arg[0], 1, atom->ntypes, ilo, ihi, error);
  utils::bounds(FLERR, arg[1], 1, atom->ntypes, jlo, jhi, error);

  LawArguments args;
  try {
    args = granwave::parse_law(std::vector<std::string>(arg + 2, arg + narg));
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: {}", fault.what());
  }
  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = std::max(jlo, i); j <= jhi; j++) {
      if (i == j && args.second)
        error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: a second material needs two different types");
      given[i * (atom_types + 1) + j] = args;
      setflag[i][j] = 1;
      count++;
    }
  if (count == 0) error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: no pair of types I <= J in {} {}", arg[0], arg[1]);
}

void PairGranHysteretic::init_style()
{
  if (!atom->radius_flag || !atom->rmass_flag)
    error->all(FLERR, "Pair style gran/hysteretic requires atom attributes radius and rmass (atom_style sphere)");
  if (!atom->tag_enable) error->all(FLERR, "Pair style gran/hysteretic requires atom IDs");
  if (force->newton_pair) error->all(FLERR, "Pair style gran/hysteretic requires 'newton off' (or 'newton off on')");

  if (std::strncmp(update->integrate_style, "respa", 5) == 0)
    error->all(FLERR, "Pair style gran/hysteretic does not work with run_style respa");

  neighbor->add_request(this);

  if (!fix_history) {
    if (modify->get_fix_by_id(FixGranHystereticHistory::ID))
      error->all(FLERR, "Only one pair style gran/hysteretic can be in use: give its laws by pair of types instead");
    fix_history = dynamic_cast<FixGranHystereticHistory *>(
        modify->add_fix(fmt::format("{} all {}", FixGranHystereticHistory::ID, FixGranHystereticHistory::STYLE)));
    fix_history->pair = this;
  }

  // largest radius by type sets the cutoff
  std::vector<double> mine(atom_types + 1, 0.0);
  for (int i = 0; i < atom->nlocal; i++) mine[atom->type[i]] = std::max(mine[atom->type[i]], atom->radius[i]);
  for (auto *fix : modify->get_fix_list())    // spheres still to come
    if (std::strncmp(fix->style, "pour", 4) == 0 || std::strncmp(fix->style, "deposit", 7) == 0)
      for (int i = 1; i <= atom_types; i++) {
        int itype = i;
        if (const auto *radius = static_cast<double *>(fix->extract("radius", itype))) mine[i] = std::max(mine[i], *radius);
      }
  MPI_Allreduce(mine.data(), largest_radius.data(), atom_types + 1, MPI_DOUBLE, MPI_MAX, world);
}

double PairGranHysteretic::init_one(int i, int j)
{
  const int n = atom_types + 1;
  LawArguments &args = given[i * n + j];
  if (!setflag[i][j]) {
    if (!setflag[i][i] || !setflag[j][j])
      error->all(FLERR, "All pair coeffs are not set: gran/hysteretic has none for types {} and {}", i, j);
    const LawArguments &a = given[i * n + i], &b = given[j * n + j];
    if (!a.same_options(b))
      error->all(FLERR, "Types {} and {} have different laws or options for like spheres: give pair_coeff {} {}", i, j, i, j);
    args = a;
    args.second = b.first;
  }
  const granwave::Material second = args.second.value_or(args.first);
  law(i, j) = args.contact(args.first, second);
  law(j, i) = args.contact(second, args.first);
  given[j * n + i] = args;
  return largest_radius[i] + largest_radius[j] + gap;
}

PairGranHysteretic::Geometry PairGranHysteretic::geometry(int itype, int jtype, double ri, double rj)
{
  Geometry g;
  g.sum_radii = ri + rj;
  const double touch = g.sum_radii * (1.0 - ROUNDING);
  g.touch_sq = touch * touch;
  g.scale = law(itype, jtype).scale(effective_radius(ri, rj));
  return g;
}

/* ---------------------------------------------------------------------- forces */

int PairGranHysteretic::turning_of(int k, double peak, const ContactLaw &contact_law)
{
  Contacts &c = contacts;
  if (c.turning[k] < 0) {
    c.turning[k] = static_cast<int>(c.turnings.size());
    c.turnings.push_back({-1.0, 0.0, 0.0, 0.0});
    c.work_lost.push_back(0.0);
  }
  const int t = c.turning[k];
  if (c.turnings[t].peak != peak) {
    c.turnings[t] = contact_law.turning(peak);
    c.work_lost[t] = -1.0;
  }
  return t;
}

/* A contact beyond its elastic limit, loading (the peak was raised just now) or below its peak. */

double PairGranHysteretic::yielding_force(int k, double overlap, const ContactLaw &contact_law, const ContactScale &scale,
                                          bool raised)
{
  if (raised) {
    if (contacts.time_yield[k] < 0.0) contacts.time_yield[k] = now;
    return scale.force * contact_law.loading(overlap / scale.overlap);
  }
  const Turning &turning = contacts.turnings[turning_of(k, contacts.peak[k] / scale.overlap, contact_law)];
  return scale.force * ContactLaw::unloading(overlap / scale.overlap, turning);
}

/* The forces on a sphere are added up in whatever order the list has, which differs with the number of processors. Twice
   the precision makes the sum, once rounded, the same in any order: a run gives the same bits on any number of ranks. */

inline void PairGranHysteretic::Sum::add(const double (&term)[3])
{
  for (int d = 0; d < 3; d++) {
    const double total = high[d] + term[d], rounded = total - high[d];
    low[d] += (high[d] - (total - rounded)) + (term[d] - rounded);    // Knuth: what the addition lost
    high[d] = total;
  }
}

template <bool UNIFORM, PairGranHysteretic::Tally TALLY> void PairGranHysteretic::forces()
{
  const double(*const x)[3] = reinterpret_cast<const double(*)[3]>(atom->x[0]);
  double(*const f)[3] = reinterpret_cast<double(*)[3]>(atom->f[0]);
  const double *const radius = atom->radius;
  const int *const type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;
  const int rows = static_cast<int>(c.row.size());
  const int *const partner = c.partner.data();
  double *const peak = c.peak.data();
  force_sums.resize(nlocal);    // all zero between force evaluations
  Sum *const sums = force_sums.data();
  const auto give = [&](int i) {
    for (int d = 0; d < 3; d++) f[i][d] += sums[i].high[d] + sums[i].low[d];
    sums[i] = Sum{};
  };

  Geometry g{};
  double forget_sq = 0.0, largest = 0.0, sum[6] = {};
  if (UNIFORM) {
    g = geometry(type[0], type[0], radius[0], radius[0]);
    forget_sq = (g.sum_radii + gap) * (g.sum_radii + gap);
    largest = radius[0];
  }

  for (int r = 0; r < rows; r++) {
    const int i = c.row[r];
    const double xi = x[i][0], yi = x[i][1], zi = x[i][2];
    Sum total = sums[i];
    const int end = c.begin[r + 1];
    for (int k = c.begin[r]; k < end; k++) {
      const int j = partner[k];
      const double dx = xi - x[j][0], dy = yi - x[j][1], dz = zi - x[j][2];
      const double rsq = dx * dx + dy * dy + dz * dz;
      if (!UNIFORM) {
        const double sum = radius[i] + radius[j];
        g.sum_radii = sum;
        g.touch_sq = sum * sum * (1.0 - 2.0 * ROUNDING);
        forget_sq = (sum + gap) * (sum + gap);
      }
      if (rsq >= g.touch_sq) {
        if (rsq > forget_sq && peak[k] > 0.0) forget(r, k);
        continue;
      }
      if (!UNIFORM) {
        g.scale = law(type[i], type[j]).scale(effective_radius(radius[i], radius[j]));
        largest = largest_overlap(radius[i], radius[j]);
      }
      const double distance = std::sqrt(rsq);
      const double overlap = g.sum_radii - distance;
      double peak_overlap = peak[k];
      const bool raised = overlap > peak_overlap;
      if (raised) {
        if (peak_overlap == 0.0) c.time_first[k] = now;
        peak[k] = peak_overlap = overlap;
        c.time_peak[k] = now;
      }
      double normal_force;
      if (peak_overlap <= g.scale.elastic_limit) {
        if (overlap > largest) overlap_error(i, j, overlap);
        normal_force = g.scale.hertz * overlap * std::sqrt(overlap);
      } else {
        if (overlap > largest) overlap_error(i, j, overlap);
        normal_force = yielding_force(k, overlap, law(type[i], type[j]), g.scale, raised);
      }
      const double pair_force = normal_force / distance;
      const double push[3] = {dx * pair_force, dy * pair_force, dz * pair_force};
      const double back[3] = {-push[0], -push[1], -push[2]};
      total.add(push);
      if (j < nlocal) sums[j].add(back);
      if (TALLY == Tally::PRESSURE) {
        const double share = j < nlocal ? pair_force : 0.5 * pair_force;
        sum[0] += dx * dx * share;
        sum[1] += dy * dy * share;
        sum[2] += dz * dz * share;
        sum[3] += dx * dy * share;
        sum[4] += dx * dz * share;
        sum[5] += dy * dz * share;
      } else if (TALLY == Tally::EACH_PAIR) {
        double elastic = 0.0;
        if (eflag_either) {
          if (peak_overlap <= g.scale.elastic_limit) {
            elastic = 0.4 * normal_force * overlap;
          } else {
            const ContactLaw &contact_law = law(type[i], type[j]);
            const Turning &turning = c.turnings[turning_of(k, peak_overlap / g.scale.overlap, contact_law)];
            elastic = g.scale.force * g.scale.overlap * ContactLaw::elastic_energy(overlap / g.scale.overlap, turning);
          }
        }
        ev_tally(i, j, nlocal, 0, elastic, 0.0, pair_force, dx, dy, dz);
      }
    }
    sums[i] = total;
    if (c.ordered) give(i);
  }
  if (!c.ordered)
    for (int i = 0; i < nlocal; i++) give(i);
  if (TALLY == Tally::PRESSURE)
    for (int k = 0; k < 6; k++) virial[k] += sum[k];
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (!contacts.valid) build_contacts();
  contacts.published = false;
  now = granwave::simulated_time(*update);

  // LAMMPS asks for the pressure more often than anybody looks at it: it must cost next to nothing
  const Tally tally = eflag_atom || vflag_atom || cvflag_atom || num_tally_compute > 0 ? Tally::EACH_PAIR
      : vflag_global                                                                   ? Tally::PRESSURE
                                                                                       : Tally::NOTHING;
  if (atom->nlocal > 0) {
    if (tally == Tally::NOTHING)
      uniform ? forces<true, Tally::NOTHING>() : forces<false, Tally::NOTHING>();
    else if (tally == Tally::PRESSURE)
      uniform ? forces<true, Tally::PRESSURE>() : forces<false, Tally::PRESSURE>();
    else
      uniform ? forces<true, Tally::EACH_PAIR>() : forces<false, Tally::EACH_PAIR>();
  }
  if (eflag_global) eng_vdwl = tally_totals();
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  const bool face = atom->radius[i] == 0.0 || atom->radius[j] == 0.0;
  error->one(FLERR, fmt::format("Spheres {} and {} overlap by {:.3g}, more than {}: they were placed into each other, or the "
                                "timestep is far too large", atom->tag[i], atom->tag[j], overlap,
                                face ? "half the radius of the one that meets a flat face" : "the radius of the smaller one"));
}

double PairGranHysteretic::memory_usage()
{
  const Contacts &c = contacts;
  double bytes = Pair::memory_usage() + double(force_sums.capacity()) * sizeof(Sum);
  bytes += double(c.partner.capacity()) * (2 * sizeof(int) + 4 * sizeof(double) + sizeof(tagint));
  bytes += double(c.partner_radius.capacity()) * (sizeof(double) + sizeof(int));
  bytes += double(c.row.capacity()) * (2 * sizeof(int) + sizeof(tagint));
  bytes += double(c.turnings.capacity()) * (sizeof(Turning) + sizeof(double));
  return bytes;
}
