#include "pair_gran_hysteretic.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "fix_gran_hysteretic_history.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using granwave::ContactLaw;
using granwave::ContactScale;
using granwave::Dent;
using granwave::DentRecord;
using granwave::Law;
using granwave::LawArguments;
using granwave::Material;
using granwave::Turning;

namespace {

constexpr int RESTART_FORMAT = 1;

// Spheres of a lattice that just touch overlap or part by the rounding of their positions. Overlaps below this part of
// the distance are that noise: the force that they would give is below 1e-12 F_y.
constexpr double ROUNDING = 5e-13;

enum { DISSIPATED, YIELDED, BEYOND_LAW, BEYOND_HALF, LARGEST_FORCE, N_TOTALS };
enum { OVERLAP, PEAK_OVERLAP, PEAK_FORCE, LOST, TIME_FIRST, TIME_PEAK, TIME_YIELD, N_SINGLE };

}    // namespace

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
    if (a.law != b.law || a.variant != b.variant || a.yield_factor != b.yield_factor || a.beta != b.beta)
      error->all(FLERR, "Types {} and {} have different laws or options for like spheres: give pair_coeff {} {}", i, j, i, j);
    args = a;
    args.second = b.first;
  }
  law(i, j) = args.contact(args.second.value_or(args.first));
  law(j, i) = ContactLaw(args.law, args.second.value_or(args.first), args.first, args.variant, args.yield_factor, args.beta);
  given[j * n + i] = args;
  return largest_radius[i] + largest_radius[j] + gap;
}

PairGranHysteretic::Geometry PairGranHysteretic::geometry(int itype, int jtype, double ri, double rj)
{
  Geometry g;
  g.sum_radii = ri + rj;
  const double touch = g.sum_radii * (1.0 - ROUNDING);
  g.touch_sq = touch * touch;
  g.scale = law(itype, jtype).scale(ri * rj / g.sum_radii);
  return g;
}

/* ---------------------------------------------------------------------- the flat list and the records of the spheres */

void PairGranHysteretic::build_contacts()
{
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nall = atom->nlocal + atom->nghost;
  const double reach = gap + neighbor->skin;

  const double widest = 2.0 * *std::max_element(largest_radius.begin(), largest_radius.end()) + reach;
  for (int axis = 0; axis < domain->dimension; axis++)
    if (domain->periodicity[axis] && domain->prd[axis] < 2.0 * widest)
      error->all(FLERR, "Pair style gran/hysteretic: the periodic box is {:.3g} long in {}, where two spheres could meet both "
                        "directly and across the boundary; it must be at least {:.3g}", domain->prd[axis], "xyz"[axis], 2.0 * widest);

  uniform = true;
  for (int i = 1; i < nall && uniform; i++) uniform = radius[i] == radius[0] && type[i] == type[0];

  Contacts &c = contacts;
  c.row.clear();
  c.begin.clear();
  c.partner.clear();
  c.row_tag.clear();
  c.partner_tag.clear();
  c.owned = atom->nlocal;
  std::size_t pairs = 0;
  for (int ii = 0; ii < list->inum; ii++) pairs += list->numneigh[list->ilist[ii]];
  c.row.reserve(list->inum);
  c.begin.reserve(list->inum + 1);
  c.partner.reserve(pairs);

  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    const int *jlist = list->firstneigh[i];
    c.row.push_back(i);
    c.begin.push_back(static_cast<int>(c.partner.size()));
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      if (force->special_lj[sbmask(jlist[jj])] == 0.0) continue;
      const int j = jlist[jj] & NEIGHMASK;
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      const double far = radius[i] + radius[j] + reach;
      if (dx * dx + dy * dy + dz * dz < far * far) c.partner.push_back(j);
    }
  }
  c.begin.push_back(static_cast<int>(c.partner.size()));

  const std::size_t n = c.partner.size();
  c.peak.assign(n, 0.0);
  c.time_first.assign(n, -1.0);
  c.time_peak.assign(n, -1.0);
  c.time_yield.assign(n, -1.0);
  c.turning.assign(n, -1);
  c.turnings.clear();
  c.work_lost.clear();
  c.row_tag.resize(c.row.size());
  c.partner_tag.resize(n);
  for (std::size_t r = 0; r < c.row.size(); r++) c.row_tag[r] = atom->tag[c.row[r]];
  for (std::size_t k = 0; k < n; k++) c.partner_tag[k] = atom->tag[c.partner[k]];
  const std::size_t rows = uniform ? std::min<std::size_t>(1, c.row.size()) : c.row.size(), pairs_kept = uniform ? std::min<std::size_t>(1, n) : n;
  c.row_radius.resize(rows);
  c.row_type.resize(rows);
  c.partner_radius.resize(pairs_kept);
  c.partner_type.resize(pairs_kept);
  for (std::size_t r = 0; r < rows; r++) {
    c.row_radius[r] = radius[c.row[r]];
    c.row_type[r] = type[c.row[r]];
  }
  for (std::size_t k = 0; k < pairs_kept; k++) {
    c.partner_radius[k] = radius[c.partner[k]];
    c.partner_type[k] = type[c.partner[k]];
  }
  refuse_leaps();
  restore_dents();
  c.valid = true;
  c.published = false;
}

/* A sphere that moves by much of its radius in one step would pass through others unseen. */

void PairGranHysteretic::refuse_leaps()
{
  constexpr double LARGEST = 0.5;    // of the radius
  const double *const *v = atom->v;
  for (int i = 0; i < atom->nlocal; i++) {
    const double leap = std::sqrt(v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]) * update->dt;
    if (!(leap <= LARGEST * atom->radius[i]))
      error->one(FLERR, "Sphere {} moves by {:.3g} of its radius in one timestep: the timestep is far too large for its "
                        "velocity, or the run is unstable", atom->tag[i], leap / atom->radius[i]);
  }
}

/* The spheres' live records become flat again. A live record whose pair is out of reach now is forgotten. */

void PairGranHysteretic::restore_dents()
{
  granwave::ContactHistory &history = fix_history->history;
  if (history.size() == 0) return;
  for (int i = 0; i < atom->nlocal; i++)
    if (history.count(i) > 0 && history.owner(i) != atom->tag[i])
      error->one(FLERR, "The ID of sphere {} was {} when its contacts were made: dents are known by the IDs of their spheres. "
                        "Use 'delete_atoms ... compress no', and no reset_atoms id", atom->tag[i], history.owner(i));
  Contacts &c = contacts;
  constexpr int FOUND = 2;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const int j = c.partner[k];
      const auto find = [&](int of, tagint partner) -> DentRecord * {
        DentRecord *record = history.records(of);
        for (int m = 0; m < history.count(of); m++, record++)
          if (record->live && record->partner == partner) return record;
        return nullptr;
      };
      DentRecord *record = find(i, c.partner_tag[k]);
      if (record) {
        c.peak[k] = record->dent.peak;
        c.time_first[k] = record->dent.time_first;
        c.time_peak[k] = record->dent.time_peak;
        c.time_yield[k] = record->dent.time_yield;
        record->live = FOUND;
      }
      if (j < atom->nlocal)
        if (DentRecord *other = find(j, c.row_tag[r])) other->live = FOUND;
    }
  }
  for (int i = 0; i < atom->nlocal; i++) {
    DentRecord *record = history.records(i);
    for (int m = 0; m < history.count(i); m++, record++)
      if (record->live == 1) record->live = 0;
  }
  history.keep_forgotten(atom->nlocal);
}

void PairGranHysteretic::publish_contacts()
{
  Contacts &c = contacts;
  if (!c.valid || c.published || !fix_history) return;
  granwave::ContactHistory &history = fix_history->history;
  const int rows = static_cast<int>(c.row.size());
  history.keep_forgotten(c.owned);
  std::vector<int> extra(c.owned, 0);
  for (int r = 0; r < rows; r++)
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++)
      if (c.peak[k] > 0.0) {
        extra[c.row[r]]++;
        if (c.partner[k] < c.owned) extra[c.partner[k]]++;
      }
  history.reserve(c.owned, extra);
  for (int r = 0; r < rows; r++) history.own(c.row[r], c.row_tag[r]);
  for (int r = 0; r < rows; r++) {
    const int of_row = uniform ? 0 : r;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.peak[k] <= 0.0) continue;
      const int of_pair = uniform ? 0 : k;
      const Dent dent{c.peak[k], c.time_first[k], c.time_peak[k], c.time_yield[k]};
      history.place(c.row[r], {c.partner_tag[k], c.partner_radius[of_pair], c.partner_type[of_pair], 1, dent});
      if (c.partner[k] < c.owned)
        history.place(c.partner[k], {c.row_tag[r], c.row_radius[of_row], c.row_type[of_row], 1, dent});
    }
  }
  c.published = true;
}

void PairGranHysteretic::release_contacts()
{
  publish_contacts();
  contacts.valid = false;
}

/* The pair has parted for good: both spheres file the dent, a new one may start. */

void PairGranHysteretic::forget(int row, int k)
{
  Contacts &c = contacts;
  const int i = c.row[row], j = c.partner[k];
  const Dent dent{c.peak[k], c.time_first[k], c.time_peak[k], c.time_yield[k]};
  granwave::ContactHistory &history = fix_history->history;
  history.own(i, c.row_tag[row]);
  if (j < atom->nlocal) history.own(j, c.partner_tag[k]);
  history.append(i, {c.partner_tag[k], atom->radius[j], atom->type[j], 0, dent});
  if (j < atom->nlocal)
    history.append(j, {c.row_tag[row], atom->radius[i], atom->type[i], 0, dent});
  c.peak[k] = 0.0;
  c.time_first[k] = c.time_peak[k] = c.time_yield[k] = -1.0;
  c.turning[k] = -1;
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
    double fx = 0.0, fy = 0.0, fz = 0.0;
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
        g.scale = law(type[i], type[j]).scale(radius[i] * radius[j] / g.sum_radii);
        largest = std::min(radius[i], radius[j]);
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
      fx += dx * pair_force;
      fy += dy * pair_force;
      fz += dz * pair_force;
      if (j < nlocal) {
        f[j][0] -= dx * pair_force;
        f[j][1] -= dy * pair_force;
        f[j][2] -= dz * pair_force;
      }
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
    f[i][0] += fx;
    f[i][1] += fy;
    f[i][2] += fz;
  }
  if (TALLY == Tally::PRESSURE)
    for (int k = 0; k < 6; k++) virial[k] += sum[k];
}

void PairGranHysteretic::compute(int eflag, int vflag)
{
  ev_init(eflag, vflag);
  if (!contacts.valid) build_contacts();
  contacts.published = false;
  now = update->atime + (update->ntimestep - update->atimestep) * update->dt;

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
  if (eflag_global) tally_totals();
}

/* Stored energy (eng_vdwl) and the extra totals of compute pair; a pair shared with another processor counts half. */

void PairGranHysteretic::tally_totals()
{
  double elastic = 0.0, largest_force = 0.0;
  std::fill_n(pvector, static_cast<int>(N_TOTALS), 0.0);
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const int *type = atom->type;
  const int nlocal = atom->nlocal;
  Contacts &c = contacts;

  const auto count = [&](const ContactLaw &contact_law, const ContactScale &scale, double peak, double dissipated,
                         double effective_radius, double weight) {
    if (peak > scale.elastic_limit) {
      pvector[YIELDED] += weight;
      pvector[DISSIPATED] += weight * dissipated;
      if (contact_law.fitted() && peak > 0.1 * effective_radius) {
        pvector[BEYOND_HALF] += weight;
        if (peak > 0.2 * effective_radius) pvector[BEYOND_LAW] += weight;
      }
      largest_force = std::max(largest_force, scale.force * contact_law.loading(peak / scale.overlap));
    } else {
      largest_force = std::max(largest_force, scale.hertz * peak * std::sqrt(peak));
    }
  };

  Geometry g{};
  if (uniform && nlocal > 0) g = geometry(type[0], type[0], radius[0], radius[0]);
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      const double peak = c.peak[k];
      if (peak == 0.0) continue;
      const int j = c.partner[k];
      const double weight = j < nlocal ? 1.0 : 0.5;
      if (!uniform) g = geometry(type[i], type[j], radius[i], radius[j]);
      const ContactLaw &contact_law = law(type[i], type[j]);
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      const double overlap = g.sum_radii - std::sqrt(dx * dx + dy * dy + dz * dz);
      double dissipated = 0.0;
      if (peak > g.scale.elastic_limit) {
        const int t = turning_of(k, peak / g.scale.overlap, contact_law);
        const double unit = g.scale.force * g.scale.overlap;
        if (c.work_lost[t] == -1.0) c.work_lost[t] = contact_law.dissipated_energy(c.turnings[t]);
        dissipated = unit * c.work_lost[t];
        if (overlap > 0.0) elastic += weight * unit * ContactLaw::elastic_energy(overlap / g.scale.overlap, c.turnings[t]);
      } else if (overlap > 0.0) {
        elastic += weight * 0.4 * g.scale.hertz * overlap * overlap * std::sqrt(overlap);
      }
      count(contact_law, g.scale, peak, dissipated, uniform ? 0.5 * radius[0] : radius[i] * radius[j] / g.sum_radii, weight);
    }
  }

  const granwave::ContactHistory &history = fix_history->history;
  if (history.size() > 0)
    for (int i = 0; i < nlocal; i++) {
      const DentRecord *record = history.records(i);
      for (int m = 0; m < history.count(i); m++, record++) {
        if (record->live) continue;
        const double effective_radius = granwave::effective_radius(radius[i], record->partner_radius);
        const ContactLaw &contact_law = law(type[i], record->partner_type);
        const ContactScale scale = contact_law.scale(effective_radius);
        const double lost = record->dent.peak > scale.elastic_limit
            ? scale.force * scale.overlap * contact_law.dissipated_energy(contact_law.turning(record->dent.peak / scale.overlap))
            : 0.0;
        count(contact_law, scale, record->dent.peak, lost, effective_radius, 0.5);
      }
    }

  double all_largest = 0.0;
  MPI_Allreduce(&largest_force, &all_largest, 1, MPI_DOUBLE, MPI_MAX, world);
  pvector[LARGEST_FORCE] = comm->me == 0 ? all_largest : 0.0;    // compute pair adds up over processors
  eng_vdwl = elastic;
  if (!std::isfinite(elastic + pvector[DISSIPATED]))
    error->one(FLERR, "Pair style gran/hysteretic: the energy of the contacts is not a number: positions or velocities "
                      "are wrong, or the timestep is far too large");
}

void PairGranHysteretic::overlap_error(int i, int j, double overlap)
{
  error->one(FLERR, fmt::format("Spheres {} and {} overlap by {:.3g}, more than the radius of the smaller one: they were "
                                "placed into each other, or the timestep is far too large", atom->tag[i], atom->tag[j], overlap));
}

/* ---------------------------------------------------------------------- reports */

PairGranHysteretic::Report PairGranHysteretic::describe(int i, int j, int k, double rsq)
{
  Contacts &c = contacts;
  const Geometry g = geometry(atom->type[i], atom->type[j], atom->radius[i], atom->radius[j]);
  const ContactLaw &contact_law = law(atom->type[i], atom->type[j]);
  Report report{};
  report.i = i;
  report.j = j;
  report.tag_i = atom->tag[i];
  report.tag_j = atom->tag[j];
  report.live = true;
  report.share_i = contact_law.share_of_first();
  report.effective_radius = atom->radius[i] * atom->radius[j] / g.sum_radii;
  report.overlap = g.sum_radii - std::sqrt(rsq);
  if (k >= 0) report.dent = {c.peak[k], c.time_first[k], c.time_peak[k], c.time_yield[k]};
  const double peak = report.dent.peak, overlap = report.overlap > ROUNDING * g.sum_radii ? report.overlap : 0.0;
  const double reached = std::max(peak, overlap);    // a pair that was moved since the last step may be beyond its peak
  if (reached > g.scale.elastic_limit) {
    const Turning turning = contact_law.turning(reached / g.scale.overlap);
    const double unit = g.scale.force * g.scale.overlap;
    report.yielded = true;
    report.force = g.scale.force * (overlap >= reached ? turning.force : ContactLaw::unloading(overlap / g.scale.overlap, turning));
    report.peak_force = g.scale.force * turning.force;
    report.elastic = unit * ContactLaw::elastic_energy(overlap / g.scale.overlap, turning);
    report.dissipated = unit * contact_law.dissipated_energy(turning);
  } else {
    report.force = g.scale.hertz * overlap * std::sqrt(overlap);
    report.peak_force = g.scale.hertz * reached * std::sqrt(reached);
    report.elastic = 0.4 * report.force * overlap;
  }
  return report;
}

void PairGranHysteretic::require_contacts()
{
  if (!contacts.valid)
    error->one(FLERR, "The contacts of pair style gran/hysteretic are not current: spheres were added, deleted or put into "
                      "another order since the last run; use 'run 0' first");
}

void PairGranHysteretic::for_each_dent(const std::function<void(const Report &)> &visit)
{
  require_contacts();
  const double *const *x = atom->x;
  Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    const int i = c.row[r];
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.peak[k] == 0.0) continue;
      const int j = c.partner[k];
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      visit(describe(i, j, k, dx * dx + dy * dy + dz * dz));
    }
  }
  const granwave::ContactHistory &history = fix_history->history;
  for (int i = 0; i < atom->nlocal; i++) {
    const DentRecord *record = history.records(i);
    for (int m = 0; m < history.count(i); m++, record++) {
      if (record->live) continue;
      const ContactLaw &contact_law = law(atom->type[i], record->partner_type);
      Report report{};
      report.i = i;
      report.j = -1;
      report.tag_i = atom->tag[i];
      report.tag_j = static_cast<tagint>(record->partner);
      report.share_i = contact_law.share_of_first();
      report.effective_radius = granwave::effective_radius(atom->radius[i], record->partner_radius);
      report.dent = record->dent;
      report.overlap = -gap;
      const ContactScale scale = contact_law.scale(report.effective_radius);
      if (record->dent.peak > scale.elastic_limit) {
        const Turning turning = contact_law.turning(record->dent.peak / scale.overlap);
        report.yielded = true;
        report.peak_force = scale.force * turning.force;
        report.dissipated = scale.force * scale.overlap * contact_law.dissipated_energy(turning);
      } else {
        report.peak_force = scale.hertz * record->dent.peak * std::sqrt(record->dent.peak);
      }
      visit(report);
    }
  }
}

void PairGranHysteretic::visit_pair(tagint one, tagint other, const std::function<void(const Report &)> &visit)
{
  require_contacts();
  const double *const *x = atom->x;
  const Contacts &c = contacts;
  for (std::size_t r = 0; r < c.row.size(); r++) {
    if (c.row_tag[r] != one && c.row_tag[r] != other) continue;
    const tagint wanted = c.row_tag[r] == one ? other : one;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++) {
      if (c.partner_tag[k] != wanted) continue;
      const int i = c.row[r], j = c.partner[k];
      const double dx = x[i][0] - x[j][0], dy = x[i][1] - x[j][1], dz = x[i][2] - x[j][2];
      visit(describe(i, j, k, dx * dx + dy * dy + dz * dz));
    }
  }
}

double PairGranHysteretic::single(int i, int j, int, int, double rsq, double, double, double &fforce)
{
  require_contacts();
  const Contacts &c = contacts;
  int found = -1;
  for (const auto &[a, b] : {std::pair<int, int>{i, j}, {j, i}}) {
    if (a >= static_cast<int>(c.row.size()) || found >= 0) continue;
    // rows follow the list of owned spheres, which is the identity unless the style shares the system with others
    std::size_t r = a;
    if (c.row[r] != a) r = std::find(c.row.begin(), c.row.end(), a) - c.row.begin();
    if (r == c.row.size()) continue;
    for (int k = c.begin[r]; k < c.begin[r + 1]; k++)
      if (c.partner[k] == b || c.partner_tag[k] == atom->tag[b]) found = k;
  }
  const Report report = describe(i, j, found, rsq);
  svector[OVERLAP] = report.overlap;
  svector[PEAK_OVERLAP] = report.dent.peak;
  svector[PEAK_FORCE] = report.peak_force;
  svector[LOST] = report.dissipated;
  svector[TIME_FIRST] = report.dent.time_first;
  svector[TIME_PEAK] = report.dent.time_peak;
  svector[TIME_YIELD] = report.dent.time_yield;
  fforce = report.force / std::sqrt(rsq);
  return report.elastic;
}

/* ---------------------------------------------------------------------- restart files */

void PairGranHysteretic::write_restart_settings(FILE *fp)
{
  fwrite(&RESTART_FORMAT, sizeof(int), 1, fp);
  fwrite(&gap, sizeof(double), 1, fp);
}

void PairGranHysteretic::read_restart_settings(FILE *fp)
{
  int format = 0;
  if (comm->me == 0) {
    utils::sfread(FLERR, &format, sizeof(int), 1, fp, nullptr, error);
    utils::sfread(FLERR, &gap, sizeof(double), 1, fp, nullptr, error);
  }
  MPI_Bcast(&format, 1, MPI_INT, 0, world);
  MPI_Bcast(&gap, 1, MPI_DOUBLE, 0, world);
  if (format != RESTART_FORMAT)
    error->all(FLERR, "Restart file holds format {} of pair style gran/hysteretic; this version reads format {}", format,
               RESTART_FORMAT);
}

namespace {

constexpr int N_STORED = 11;

void store(const LawArguments &a, double *v)
{
  const Material second = a.second.value_or(Material{0, 0, 0});
  const double values[N_STORED] = {double(a.law), a.first.youngs_modulus, a.first.poisson_ratio, a.first.yield_strength,
                                   double(a.second.has_value()), second.youngs_modulus, second.poisson_ratio,
                                   second.yield_strength, double(a.variant), a.yield_factor, a.beta};
  std::copy_n(values, N_STORED, v);
}

LawArguments recall(const double *v)
{
  LawArguments a;
  a.law = static_cast<Law>(int(v[0]));
  a.first = {v[1], v[2], v[3]};
  if (v[4] != 0.0) a.second = Material{v[5], v[6], v[7]};
  a.variant = static_cast<granwave::Variant>(int(v[8]));
  a.yield_factor = v[9];
  a.beta = v[10];
  return a;
}

}    // namespace

void PairGranHysteretic::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  double values[N_STORED];
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      fwrite(&setflag[i][j], sizeof(int), 1, fp);
      store(given[i * (atom_types + 1) + j], values);
      if (setflag[i][j]) fwrite(values, sizeof(double), N_STORED, fp);
    }
}

void PairGranHysteretic::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  double values[N_STORED];
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      if (comm->me == 0) utils::sfread(FLERR, &setflag[i][j], sizeof(int), 1, fp, nullptr, error);
      MPI_Bcast(&setflag[i][j], 1, MPI_INT, 0, world);
      if (!setflag[i][j]) continue;
      if (comm->me == 0) utils::sfread(FLERR, values, sizeof(double), N_STORED, fp, nullptr, error);
      MPI_Bcast(values, N_STORED, MPI_DOUBLE, 0, world);
      given[i * (atom_types + 1) + j] = recall(values);
    }
}

double PairGranHysteretic::memory_usage()
{
  const Contacts &c = contacts;
  double bytes = Pair::memory_usage();
  bytes += double(c.partner.capacity()) * (2 * sizeof(int) + 4 * sizeof(double) + sizeof(tagint));
  bytes += double(c.partner_radius.capacity()) * (sizeof(double) + sizeof(int));
  bytes += double(c.row.capacity()) * (2 * sizeof(int) + sizeof(tagint));
  bytes += double(c.turnings.capacity()) * (sizeof(Turning) + sizeof(double));
  return bytes;
}
