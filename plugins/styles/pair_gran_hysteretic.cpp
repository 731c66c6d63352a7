// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: settings, coefficients and requirements, and their content in restart files. */

#include "pair_gran_hysteretic.h"

#include "comm.h"
#include "error.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "motion.h"
#include "neighbor.h"
#include "restart_state.h"

using namespace LAMMPS_NS;
using namespace granwave;

PairGranHysteretic *PairGranHysteretic::find(Force *force)
{
  return dynamic_cast<PairGranHysteretic *>(force->pair_match("^gran/hysteretic", 0));
}

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
  comm_forward = std::max(MovedMass::SIZE, GhostVelocities::SIZE);
}

PairGranHysteretic::~PairGranHysteretic()
{
  delete[] svector;
  delete[] pvector;
  if (copymode) return;
  if (fix_history) {
    fix_history->publish_contacts = fix_history->suspend_contacts = nullptr;
    fix_history->hand_over_contacts = nullptr;
    fix_history->lose_contacts = fix_history->return_to_start = nullptr;
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
  const int n = atom->ntypes + 1;
  memory->create(setflag, n, n, "pair:setflag");
  for (int i = 0; i < n; i++) std::fill_n(setflag[i], n, 0);
  memory->create(cutsq, n, n, "pair:cutsq");
  laws.allocate(atom->ntypes);
  largest_radius.assign(n, 0.0);
}

void PairGranHysteretic::settings(int narg, char **arg)
{
  std::map<std::string, std::string> options{{"forgotten", "sum"}, {"normals", "current"}};
  const std::map<std::string, std::string> others{{"forgotten", "list"}, {"normals", "initial"}};
  bool valid = narg % 2 == 1;
  for (int n = 1; valid && n < narg; n += 2) {
    const auto option = options.find(arg[n]);
    valid = option != options.end() && (arg[n + 1] == option->second || arg[n + 1] == others.at(arg[n]));
    if (valid) option->second = arg[n + 1];
  }
  if (!valid)
    error->all(
        FLERR,
        "Illegal pair_style gran/hysteretic: expected the gap beyond which an indentation is forgotten, and optionally "
        "'forgotten sum' or 'forgotten list' and 'normals current' or 'normals initial', found '{}'",
        utils::join_words(std::vector<std::string>(arg, arg + narg), " "));
  lists_forgotten = options["forgotten"] == "list";
  normals_initial = options["normals"] == "initial";
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
    args = parse_law(std::vector<std::string>(arg + 2, arg + narg));
  } catch (const std::invalid_argument &fault) {
    error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: {}", fault.what());
  }
  int count = 0;
  for (int i = ilo; i <= ihi; i++)
    for (int j = std::max(jlo, i); j <= jhi; j++) {
      if (i == j && args.second)
        error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: a second material requires two different types");
      laws.arguments(i, j) = args;
      setflag[i][j] = 1;
      count++;
    }
  if (count == 0)
    error->all(FLERR, "Incorrect pair_coeff for gran/hysteretic: no pair of types I <= J in {} {}", arg[0], arg[1]);
}

void PairGranHysteretic::init_style()
{
  if (!atom->radius_flag || !atom->rmass_flag)
    error->all(FLERR, "Pair style gran/hysteretic requires atom attributes radius and rmass (atom_style sphere)");
  if (!atom->tag_enable) error->all(FLERR, "Pair style gran/hysteretic requires atom IDs");
  if (force->newton_pair) error->all(FLERR, "Pair style gran/hysteretic requires 'newton off' (or 'newton off on')");
  if (lost_contacts)
    error->all(FLERR, "Fix {} stores the contacts of pair style gran/hysteretic and was deleted: never unfix it",
               FixGranHystereticHistory::ID);

  refuse_respa(lmp, "Pair style gran/hysteretic");
  if (update->whichflag == 2) refuse_line_searches();

  const int n_extra = find_memory();
  if (has_dashpot) masses.find(lmp);
  if (has_dashpot) require_mechanical_units(lmp, "Pair style gran/hysteretic with a dashpot");
  radii_vary = radii_may_change(lmp);
  if (has.friction && (!atom->omega_flag || !atom->torque_flag))
    error->all(FLERR,
               "Pair style gran/hysteretic with friction requires atom attributes omega and torque (atom_style sphere)");
  sends_velocities = (has.friction || has.loss || has.cohesion || has_rate) && comm->ghost_velocity == 0;
  if (sends_velocities) ghosts.start(lmp, has.friction);

  neighbor->add_request(this);

  if (!fix_history) create_history(n_extra);
  fix_history->history.extend({n_extra, has.friction, has.dents});

  require_bodies();
  laws.begin_run(FixGranCylinder::find(lmp));
  geometry.begin_run(fix_history, find_initial_places());
  find_largest_radii();
}

/* Determine the state of the contacts of all laws, and the laws that need velocities and masses. Returns the doubles of a
   block. */
int PairGranHysteretic::find_memory()
{
  ContactMemory wanted = has;
  has_dashpot = false;
  int n_extra = 0;
  has_rate = false;
  for (int i = 1; i <= laws.types(); i++)
    for (int j = i; j <= laws.types(); j++) {
      if (!setflag[i][j]) continue;
      const LawArguments &args = laws.arguments(i, j);
      wanted.extend(args);
      has_dashpot = has_dashpot || args.loss.kind == LossKind::DASHPOT;
      n_extra = std::max(n_extra, args.n_extra());
      has_rate = has_rate || args.has_rate();
    }
  n_extra += wanted.size();
  if (fix_history && ((wanted.friction && !has.friction) || n_extra > has.n))
    release_contacts();    // its list lacks these variables
  if (has.size() > 0 && fix_history && n_extra > fix_history->history.layout().n_extra)
    error->all(
        FLERR,
        "Pair style gran/hysteretic: a law with more history variables than before cannot be added once contacts have {}: "
        "define all laws before the first run",
        has.loss         ? "a loss"
        : has.resistance ? "a resistance to rolling or twisting"
        : has.cohesion   ? "cohesion"
                         : "partial slip");
  contacts.discard_turnings();    // the law may be different
  wanted.n = has.n;               // until a new list is built
  has = wanted;
  return n_extra;
}

/* Create the fix that stores the contacts with their spheres; from a restart file it has those of the file. */
void PairGranHysteretic::create_history(int n_extra)
{
  if (modify->get_fix_by_id(FixGranHystereticHistory::ID))
    error->all(FLERR, "Only one pair style gran/hysteretic can be in use: give its laws by pair of types instead");
  fix_history = dynamic_cast<FixGranHystereticHistory *>(
      modify->add_fix(fmt::format("{} all {}", FixGranHystereticHistory::ID, FixGranHystereticHistory::STYLE)));
  fix_history->publish_contacts = [this] { publish_contacts(); };
  fix_history->suspend_contacts = [this] { contacts.suspend(fix_history->history); };
  fix_history->hand_over_contacts = [this](int i) { contacts.hand_over(fix_history->history, i); };
  fix_history->return_to_start = [this] { contacts.return_to_start(); };
  fix_history->lose_contacts = [this] {
    fix_history = nullptr;
    contacts.valid = false;
    lost_contacts = true;
  };
  fix_history->agree_on_layout();
  if (from_restart && !fix_history->restart_reset)
    error->all(FLERR, "The restart file is damaged: it contains no contacts of pair style gran/hysteretic");
  if (const int kept = fix_history->history.layout().n_extra;
      (has.resistance || has.cohesion || has.slip || has.damping || has.prony) && kept > 0 && kept != n_extra)
    error->all(FLERR,
               "Restart file contains pair style gran/hysteretic with another loss, another cohesion, other resistances "
               "to rolling and twisting or another tangential model: give them again as in the file");
}

/* Stop with an error if an atom has no radius or mass. */
void PairGranHysteretic::require_bodies()
{
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->radius[i] >= 0.0))
      error->one(FLERR,
                 "Pair style gran/hysteretic: atom {} has the radius {:g}, expected a radius above 0, or 0 for a flat face",
                 atom->tag[i], atom->radius[i]);
    if (!(atom->rmass[i] > 0.0))
      error->one(FLERR, "Pair style gran/hysteretic: atom {} has the mass {:g}, expected a mass above 0", atom->tag[i],
                 atom->rmass[i]);
  }
}

/* Find the largest radius of each type, also of spheres to be inserted: it determines the cutoff. */
void PairGranHysteretic::find_largest_radii()
{
  std::vector<double> mine(laws.types() + 1, 0.0);
  for (int i = 0; i < atom->nlocal; i++) mine[atom->type[i]] = std::max(mine[atom->type[i]], atom->radius[i]);
  for (auto *fix : modify->get_fix_list())    // spheres to be inserted
    if (std::strncmp(fix->style, "pour", 4) == 0 || std::strncmp(fix->style, "deposit", 7) == 0)
      for (int i = 1; i <= laws.types(); i++) {
        int itype = i;
        if (const auto *radius = static_cast<double *>(fix->extract("radius", itype))) mine[i] = std::max(mine[i], *radius);
      }
  MPI_Allreduce(mine.data(), largest_radius.data(), laws.types() + 1, MPI_DOUBLE, MPI_MAX, world);
}

/* A line search evaluates trial positions, each of which would leave a dent. */
void PairGranHysteretic::refuse_line_searches()
{
  const std::string search = update->minimize_style;
  if (search != "cg" && search != "sd" && search != "hftn") return;
  for (int i = 1; i <= laws.types(); i++)
    for (int j = i; j <= laws.types(); j++) {
      const LawArguments &args = laws.arguments(i, j);
      if (setflag[i][j] && (args.law->yields() || args.options.cohesion))
        error->all(FLERR,
                   "Pair style gran/hysteretic: min_style {} evaluates trial positions, each of which would change the "
                   "history with law {}: use min_style fire",
                   search, args.words.front());
    }
}

double PairGranHysteretic::init_one(int i, int j)
{
  LawArguments &args = laws.arguments(i, j);
  if (!setflag[i][j]) {
    if (!setflag[i][i] || !setflag[j][j])
      error->all(FLERR, "All pair coeffs are not set: gran/hysteretic has none for types {} and {}", i, j);
    const LawArguments &a = laws.arguments(i, i), &b = laws.arguments(j, j);
    if (!a.same_options(b))
      error->all(FLERR, "Types {} and {} have different laws or options for identical spheres: give pair_coeff {} {}", i, j,
                 i, j);
    args = a;
    args.second = b.first;
  }
  laws.make(i, j);
  return init_shape(i, j);
}

/* Set the parameters of the pairs as far as they are the same in all steps: of all pairs if all spheres are equal, and by types
   if spheres of a type are. */
void PairGranHysteretic::set_parameters()
{
  laws.discard_table();
  if (radii_vary) return;
  if (uniform) {
    batch.parameters[0] = pair_parameters(0, 0);
    for (int m = 0; m < Batch::CAPACITY; m++) batch.set(m, batch.parameters[0]);
    return;
  }
  std::vector<double> radius(laws.types() + 1, -1.0);    // of the spheres of a type
  for (int i = 0; i < atom->nlocal + atom->nghost; i++) {
    double &of_type = radius[atom->type[i]];
    if (of_type >= 0.0 && of_type != atom->radius[i]) return;
    of_type = atom->radius[i];
  }
  laws.fill_table(radius);
}

/* ---------------------------------------------------------------------- restart */

void PairGranHysteretic::write_restart_settings(FILE *fp)
{
  fwrite(&RESTART_FORMAT, sizeof(int), 1, fp);
  write_state(fp, {gap, double(has.friction), double(has.dents), double(lists_forgotten), double(has.resistance),
                   double(has.slip), double(has.cohesion), double(normals_initial)});
}

void PairGranHysteretic::read_restart_settings(FILE *fp)
{
  int format = 0;
  if (comm->me == 0) utils::sfread(FLERR, &format, sizeof(int), 1, fp, nullptr, error);
  MPI_Bcast(&format, 1, MPI_INT, 0, world);
  if (format < EARLIEST_RESTART_FORMAT || format > RESTART_FORMAT)
    error->all(FLERR,
               "Restart file contains format {} of pair style gran/hysteretic; this version reads formats {} to {}. "
               "Start the simulation again, or continue it with the version of granwave that wrote the file",
               format, EARLIEST_RESTART_FORMAT, RESTART_FORMAT);
  const std::vector<double> settings = read_state(lmp, fp, "the settings of pair style gran/hysteretic");
  from_restart = true;
  const double *setting = settings.data();
  gap = *setting++;
  for (bool *flag :
       {&has.friction, &has.dents, &lists_forgotten, &has.resistance, &has.slip, &has.cohesion, &normals_initial})
    *flag = *setting++ != 0.0;
}

/* Write the words of the pair_coeff commands, a line for each pair of types, in a whole number of doubles. */
void PairGranHysteretic::write_restart(FILE *fp)
{
  write_restart_settings(fp);
  std::string text;
  for (int i = 1; i <= laws.types(); i++)
    for (int j = i; j <= laws.types(); j++)
      if (setflag[i][j]) text += fmt::format("{} {} {}\n", i, j, utils::join_words(laws.arguments(i, j).words, " "));
  std::vector<double> state(text.size() / sizeof(double) + 1);
  text.resize(state.size() * sizeof(double), ' ');
  std::memcpy(state.data(), text.data(), text.size());
  write_state(fp, state);
}

void PairGranHysteretic::read_restart(FILE *fp)
{
  read_restart_settings(fp);
  allocate();
  const std::vector<double> state = read_state(lmp, fp, "the laws of pair style gran/hysteretic");
  std::string text(state.size() * sizeof(double), ' ');
  std::memcpy(text.data(), state.data(), text.size());
  for (const std::string &line : utils::split_lines(text)) {
    std::vector<std::string> words = utils::split_words(line);
    std::vector<char *> args;
    for (std::string &word : words) args.push_back(word.data());
    if (!args.empty()) coeff(static_cast<int>(args.size()), args.data());
  }
}

double PairGranHysteretic::memory_usage() { return Pair::memory_usage() + contacts.bytes(); }
