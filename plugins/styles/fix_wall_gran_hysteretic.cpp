// SPDX-License-Identifier: GPL-2.0-only
/* Fix wall/gran/hysteretic: arguments, spheres at the wall, and motion of the plane. Forces of one contact and
   totals are in fix_wall_gran_hysteretic_contact.cpp, per-sphere state, initial dents and restart files in
   fix_wall_gran_hysteretic_state.cpp. */

#include "fix_wall_gran_hysteretic.h"

#include "../kernels/tube.h"
#include "../laws/law_arguments.h"

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "motion.h"
#include "neighbor.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

/* Content of a file, which the first processor reads for all. Throws std::invalid_argument on all of them if it cannot be read. */
std::string shared_content(LAMMPS *lmp, const std::string &path)
{
  constexpr std::size_t PIECE = std::size_t(1) << 30;    // bytes of a message
  std::string content, fault;
  if (lmp->comm->me == 0) {
    try {
      content = content_of(path);
    } catch (const std::invalid_argument &unreadable) {
      fault = unreadable.what();
    }
  }
  for (std::string *const text : {&fault, &content}) {
    bigint size = static_cast<bigint>(text->size());
    MPI_Bcast(&size, 1, MPI_LMP_BIGINT, 0, lmp->world);
    text->resize(static_cast<std::size_t>(size));
    for (std::size_t begin = 0; begin < text->size(); begin += PIECE)
      MPI_Bcast(text->data() + begin, static_cast<int>(std::min(PIECE, text->size() - begin)), MPI_CHAR, 0, lmp->world);
  }
  if (!fault.empty()) throw std::invalid_argument(fault);
  return content;
}

}    // namespace

FixWallGranHysteretic::FixWallGranHysteretic(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 7)
    error->all(FLERR,
               "Illegal fix {}: expected xplane|yplane|zplane LO HI, tube RADIUS, region ID FACE or mesh FILE ANGLE PATCH, "
               "a law and its constants",
               STYLE);
  std::vector<std::string> words(arg + read_wall(arg), arg + narg);
  try {
    read_support(words);
    const LawArguments args = parse_law(words);
    body = args.first;
    wall = args.second.value_or(Material{INFINITE, 0.0, INFINITE});
    law = args.contact(body, wall);
    friction = args.friction;
    tangential_model = args.tangential;
    loss = args.loss;
    resistance = args.resistance;
    has.extend(args);
    if (has.cohesion && curved && std::strcmp(curved->kind(), "mesh") == 0)
      throw std::invalid_argument("a mesh holds spheres without cohesion");
    has.loss_first = true;
    has.n = law.n_extra() + has.size();
    histories.set_contents(friction > 0.0, has.n, law.n_extra());
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Illegal fix {}: {}", STYLE, fault.what());
  }

  restart_peratom = 1;
  restart_global = support ? 1 : 0;
  create_attribute = 1;
  scalar_flag = vector_flag = 1;
  size_vector = std::size(extensive);
  global_freq = 1;
  extscalar = 1;
  extvector = -1;
  extlist = extensive;
  peratom_flag = 1;
  size_peratom_cols = N_REPORTED;
  peratom_freq = 1;
  maxexchange = n_state();
  std::fill_n(wall_force, 3, 0.0);
  std::fill_n(totals, static_cast<int>(N_TOTALS), 0.0);

  FixWallGranHysteretic::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
  for (int i = 0; i < atom->nlocal; i++) FixWallGranHysteretic::set_arrays(i);
}

/* Read the position of the wall. Returns the number of words before the law. */
int FixWallGranHysteretic::read_wall(char **arg)
{
  std::fill_n(plane, 2, INFINITE);
  plane[0] = -INFINITE;
  int used_words = 6;
  if (std::strcmp(arg[3], "tube") == 0) {
    used_words = 5;
    curved = std::make_unique<Tube>(positive_number(lmp, STYLE, "radius of the tube", arg[4]));
  } else if (std::strcmp(arg[3], "region") == 0) {
    try {
      curved = std::make_unique<RegionWall>(lmp, arg[4], arg[5]);
    } catch (const std::invalid_argument &fault) {
      error->all(FLERR, "Illegal fix {}: {}", STYLE, fault.what());
    }
  } else if (std::strcmp(arg[3], "mesh") == 0) {
    used_words = 7;
    try {
      const double angle = utils::numeric(FLERR, arg[5], false, lmp);
      const int patch = utils::inumeric(FLERR, arg[6], false, lmp);
      curved = std::make_unique<MeshWall>(arg[4], shared_content(lmp, arg[4]), angle, patch);
    } catch (const std::invalid_argument &fault) {
      error->all(FLERR, "Illegal fix {} mesh {}: {}", STYLE, arg[4], fault.what());
    }
  } else {
    axis = arg[3][0] - 'x';
    if (axis < 0 || axis > 2 || std::strcmp(arg[3] + 1, "plane") != 0)
      error->all(FLERR, "Illegal fix {}: expected xplane, yplane, zplane, tube, region or mesh, found {}", STYLE, arg[3]);
    for (int side = 0; side < 2; side++)
      if (std::strcmp(arg[4 + side], "NULL") != 0) plane[side] = utils::numeric(FLERR, arg[4 + side], false, lmp);
    if (!(plane[0] < plane[1])) error->all(FLERR, "Illegal fix {}: LO must be below HI, found {} {}", STYLE, arg[4], arg[5]);
  }
  return used_words;
}

/* Read the support of the wall and the contact of cylinders with it, and remove these words from those of the law. */
void FixWallGranHysteretic::read_support(std::vector<std::string> &words)
{
  if (const auto at = std::find(words.begin(), words.end(), "support"); at != words.end()) {
    std::size_t used = 0;
    support = std::make_unique<Support>(std::vector<std::string>(at + 1, words.end()), used);
    words.erase(at, at + 1 + used);
    if (curved) throw std::invalid_argument(std::string("support moves a plane, found a ") + curved->kind());
    if (std::isfinite(plane[0]) && std::isfinite(plane[1]))
      throw std::invalid_argument("support moves one plane, found two: use a fix for each");
    if (!std::isfinite(plane[0]) && !std::isfinite(plane[1]))
      throw std::invalid_argument("support moves a plane, found none");
    moving = std::isfinite(plane[0]) ? 0 : 1;
  }
  if (const auto at = std::find(words.begin(), words.end(), "line"); at != words.end()) {
    const std::string kind = at + 1 == words.end() ? "" : at[1];
    if (kind != "half-space" && kind != "plane-strain")
      throw std::invalid_argument("line must be half-space or plane-strain, found '" + kind + "'");
    plane_strain = kind == "plane-strain";
    words.erase(at, at + 2);
  }
}

int FixWallGranHysteretic::setmask()
{
  const int forces = FixConst::POST_FORCE | FixConst::MIN_POST_FORCE | FixConst::POST_NEIGHBOR | FixConst::MIN_POST_NEIGHBOR;
  const int all = forces | FixConst::MIN_PRE_EXCHANGE;
  return support ? all | FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE : all;
}

void FixWallGranHysteretic::init()
{
  refuse_respa(lmp, fmt::format("Fix {}", STYLE));
  if (!atom->radius_flag) error->all(FLERR, "Fix {} requires atom attribute radius (atom_style sphere)", STYLE);
  if (loss && !atom->rmass_flag)
    error->all(FLERR, "Fix {} with a loss requires atom attribute rmass (atom_style sphere)", STYLE);
  if (has.friction && !(atom->omega_flag && atom->torque_flag))
    error->all(FLERR, "Fix {} with friction requires atom attributes omega and torque (atom_style sphere)", STYLE);
  const bool in_space = curved && curved->is_in_space(), is_tube = curved && !in_space;
  if (!in_space && (is_tube ? domain->periodicity[0] || domain->periodicity[1] : domain->periodicity[axis]))
    error->all(FLERR, "Fix {}: the box is periodic across the wall", STYLE);
  if (!in_space && domain->triclinic && (is_tube || axis < 2) &&
      (domain->xz != 0.0 || (axis == 0 ? domain->xy : domain->yz) != 0.0))
    error->all(FLERR, "Fix {} {}: the box is tilted across the wall, which a periodic boundary would then shift", STYLE, id);
  if (support || has_dashpot())
    require_mechanical_units(lmp, fmt::format("Fix {} {} with {}", STYLE, id, support ? "a support" : "a dashpot"));
  grows = radii_may_change(lmp);
  try {
    if (curved) curved->init(neighbor->skin);
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Fix {} {}: {}", STYLE, id, fault.what());
  }
  init_cylinders();
  if (has_dashpot()) masses.find(lmp, this);
  reset_dt();
}

void FixWallGranHysteretic::reset_dt()
{
  if (update->whichflag == 1) check_timestep(0.0);
}

void *FixWallGranHysteretic::extract(const char *name, int &dim)
{
  dim = 0;
  return std::strcmp(name, "friction") == 0 ? &friction : nullptr;
}

/* ---------------------------------------------------------------------- motion of the plane */

void FixWallGranHysteretic::setup(int)
{
  listed = false;
  if (is_rerun(*update) && (support || friction > 0.0 || loss || resistance || has.cohesion || law.n_extra() > 0))
    error->all(FLERR, "Fix {} {}: rerun lacks the steps between its snapshots, which a wall with {} requires", STYLE, id,
               support ? "a support" : "more history than a dent");
  evaluate();
}

void FixWallGranHysteretic::min_setup(int)
{
  keep_start();
  setup(0);
}

/* Prepare the exchange of spheres between processors, with the initial histories of the minimization. */
void FixWallGranHysteretic::min_pre_exchange()
{
  return_to_start();
  start.kept = false;
}

void FixWallGranHysteretic::keep_start()
{
  const std::size_t n = atom->nlocal;
  start.kept = true;
  start.histories = histories;
  start.fronts.assign(fronts.begin(), fronts.begin() + static_cast<std::ptrdiff_t>(n));
  start.reports.clear();
  for (std::size_t i = 0; i < n; i++) start.reports.insert(start.reports.end(), array_atom[i], array_atom[i] + N_REPORTED);
}

/* Only spheres that may have touched a wall have changed. Spheres whose present force is not known count as near. */
void FixWallGranHysteretic::return_to_start()
{
  if (!start.kept) return;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!touched[i]) continue;
    histories.take(start.histories, i, i);
    std::copy_n(start.reports.data() + static_cast<std::size_t>(i) * N_REPORTED, static_cast<int>(N_REPORTED),
                array_atom[i]);
    fronts[i] = start.fronts[i];
    near[i] = 1;
  }
}

void FixWallGranHysteretic::min_post_force(int)
{
  if (!start.kept) keep_start();
  return_to_start();
  if (support) support->settle(contact_stiffness);
  evaluate();
}

/* fix_modify ID velocity V: of a free plate, towards the spheres. */
int FixWallGranHysteretic::modify_param(int narg, char **arg)
{
  if (std::strcmp(arg[0], "velocity") != 0) return 0;
  if (narg < 2) error->all(FLERR, "Illegal fix_modify {}: expected velocity V", id);
  if (!support || !support->launch(utils::numeric(FLERR, arg[1], false, lmp)))
    error->all(FLERR, "Illegal fix_modify {}: velocity requires a free plate (support free)", id);
  return 2;
}

/* Present position of the lower or upper plane. */
double FixWallGranHysteretic::level(int side) const
{
  if (!support || side != moving) return plane[side];
  return plane[side] + (side == 0 ? -1.0 : 1.0) * support->displacement();
}

double FixWallGranHysteretic::depth(int i, int side) const
{
  if (curved) return side == 0 ? -INFINITE : curved->overlap(atom->x[i], atom->radius[i]);
  const double along = atom->x[i][axis], radius = atom->radius[i];
  return side == 0 ? level(0) + radius - along : along + radius - level(1);
}

/* Unit normal of a wall at sphere i, into the packing. */
void FixWallGranHysteretic::inward(int i, int side, double normal[3]) const
{
  if (curved) return curved->inward(atom->x[i], normal);
  normal[0] = normal[1] = normal[2] = 0.0;
  normal[axis] = side == 0 ? 1.0 : -1.0;
}

/* Location of sphere i along the wall. */
void FixWallGranHysteretic::place_of(int i, double place[3]) const
{
  if (curved) return curved->place(atom->x[i], place);
  place[0] = atom->x[i][(axis + 1) % 3];
  place[1] = atom->x[i][(axis + 2) % 3];
  place[2] = 0.0;
}

/* Sum the force on the plane over all processors, bitwise identical on each. */
void FixWallGranHysteretic::push_support()
{
  static_assert(sizeof(on_plane) == 2 * ExactSum::SIZE * sizeof(std::int64_t));
  ExactSum all[2];
  MPI_Allreduce(on_plane->data(), all->data(), 2 * ExactSum::SIZE, MPI_LONG_LONG, MPI_SUM, world);
  support->push(all[0].value());
  contact_stiffness = all[1].value();
  if (update->whichflag == 1) check_timestep(contact_stiffness);
}

void FixWallGranHysteretic::check_timestep(double contacts) const
{
  if (!support || update->dt <= support->critical_timestep(contacts)) return;
  error->all(
      FLERR,
      "Fix {} {}: the timestep {:.4g} is above the critical timestep of the support{}, {:.4g}: use a shorter timestep",
      STYLE, id, update->dt, contacts > 0.0 ? " with the spheres on it" : "", support->critical_timestep(contacts));
}

/* ---------------------------------------------------------------------- forces */

void FixWallGranHysteretic::evaluate()
{
  double **f = atom->f;
  const double *const *x = atom->x;
  const double *radius = atom->radius;
  const double now = simulated_time(*update);
  const double at[2] = {level(0), level(1)};
  std::fill_n(wall_force, 3, 0.0);
  on_plane[0] = on_plane[1] = {};
  tallied = -1;
  const bool arrived = !listed;    // after reneighboring: all spheres that are new on this processor count as near
  if (!listed || grows || (support && std::fabs(level(moving) - listed_level) > 0.5 * neighbor->skin)) list_spheres();
  if (cylinders)
    for (const int i : spheres)
      if (atom->mask[i] & groupbit) admit_type(atom->type[i]);
  if (has_lines) compute_lines(at);
  for (std::size_t n = 0; n < spheres.size(); n++) {
    const int i = spheres[n];
    if (!meets_walls(i)) {
      if (near[i]) part(i);
      continue;
    }
    const double overlap[2] = {curved ? -INFINITE : at[0] + radius[i] - x[i][axis],
                               curved ? depth(i, 1) : x[i][axis] + radius[i] - at[1]};
    const bool touches[2] = {joins(i, 0, overlap[0]), joins(i, 1, overlap[1])};
    if (!touches[0] && !touches[1] && !near[i]) continue;
    near[i] = touches[0] || touches[1];
    array_atom[i][OVERLAP] = array_atom[i][FORCE] = array_atom[i][TANGENTIAL] = 0.0;
    for (int side = 0; side < 2; side++) {
      Side &mine = histories.side(i, side);
      if (!touches[side] && mine.touching == 0.0) continue;
      Contact contact{};
      if (touches[side]) {
        contact = compute_normal(i, side, overlap[side], now, 2 * n + side);
        if (curved) {
          double push[3];
          inward(i, side, push);
          for (int d = 0; d < 3; d++) f[i][d] += push[d] * contact.force;
          wall_force[0] += contact.force;    // outward
        } else {
          const double push = contact.force * (side == 0 ? 1.0 : -1.0);
          f[i][axis] += push;
          wall_force[axis] -= push;
        }
        if (support) {
          on_plane[0].add(contact.force);
          on_plane[1].add(contact.stiffness);
        }
      } else {
        mine.touching = 0.0;
        if (loss) part_viscous(loss, has, scaled_law(i), extra(i, side), overlap[side], step(), simulated_time(*update));
      }
      if (friction > 0.0) compute_tangential(i, side, overlap[side], contact);
      if (resistance) compute_resistance(i, side, contact);
    }
    report_losses(i);
  }
  if (arrived) list_spheres();
  if (support) push_support();
}
