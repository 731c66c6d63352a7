// SPDX-License-Identifier: GPL-2.0-only
/* Pair style gran/hysteretic: settings, coefficients, requirements, and what of them is in restart files. */

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
  atom_types = atom->ntypes;
  const int n = atom_types + 1;
  memory->create(setflag, n, n, "pair:setflag");
  for (int i = 0; i < n; i++) std::fill_n(setflag[i], n, 0);
  memory->create(cutsq, n, n, "pair:cutsq");
  laws.assign(n * n, ContactLaw());
  coefficients.assign(n * n, LawArguments());
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
      coefficients[i * (atom_types + 1) + j] = args;
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

  ContactMemory wanted = has;
  has_dashpot = false;
  int n_extra = 0;
  has_rate = false;
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      if (!setflag[i][j]) continue;
      const LawArguments &args = coefficients[i * (atom_types + 1) + j];
      args.extend(wanted);
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
  contacts.discard_turnings();    // a law may be another one
  wanted.n = has.n;               // until a new list is built
  has = wanted;
  if (has_dashpot) masses.find(lmp);
  if (has_dashpot) require_mechanical_units(lmp, "Pair style gran/hysteretic with a dashpot");
  radii_vary = radii_may_change(lmp);
  if (has.friction && (!atom->omega_flag || !atom->torque_flag))
    error->all(FLERR,
               "Pair style gran/hysteretic with friction requires atom attributes omega and torque (atom_style sphere)");
  sends_velocities = (has.friction || has.loss || has.cohesion || has_rate) && comm->ghost_velocity == 0;
  if (sends_velocities) ghosts.start(lmp, has.friction);

  neighbor->add_request(this);

  if (!fix_history) {
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
  fix_history->history.extend({n_extra, has.friction, has.dents});

  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->radius[i] >= 0.0))
      error->one(FLERR,
                 "Pair style gran/hysteretic: atom {} has the radius {:g}, expected a radius above 0, or 0 for a flat face",
                 atom->tag[i], atom->radius[i]);
    if (!(atom->rmass[i] > 0.0))
      error->one(FLERR, "Pair style gran/hysteretic: atom {} has the mass {:g}, expected a mass above 0", atom->tag[i],
                 atom->rmass[i]);
  }

  cylinders = FixGranCylinder::find(lmp);
  find_initial_places();
  has_special = false;
  special_types.assign((atom_types + 1) * (atom_types + 1), 0);
  geometries.clear();
  geometries.resize(special_types.size());
  special_pairs.clear();

  // the largest radius of each type determines the cutoff
  std::vector<double> mine(atom_types + 1, 0.0);
  for (int i = 0; i < atom->nlocal; i++) mine[atom->type[i]] = std::max(mine[atom->type[i]], atom->radius[i]);
  for (auto *fix : modify->get_fix_list())    // spheres to be inserted
    if (std::strncmp(fix->style, "pour", 4) == 0 || std::strncmp(fix->style, "deposit", 7) == 0)
      for (int i = 1; i <= atom_types; i++) {
        int itype = i;
        if (const auto *radius = static_cast<double *>(fix->extract("radius", itype))) mine[i] = std::max(mine[i], *radius);
      }
  MPI_Allreduce(mine.data(), largest_radius.data(), atom_types + 1, MPI_DOUBLE, MPI_MAX, world);
}

/* A line search tries positions that it does not keep, and each would leave its dent. */
void PairGranHysteretic::refuse_line_searches()
{
  const std::string search = update->minimize_style;
  if (search != "cg" && search != "sd" && search != "hftn") return;
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++) {
      const LawArguments &args = coefficients[i * (atom_types + 1) + j];
      if (setflag[i][j] && (args.law->yields() || args.options.cohesion))
        error->all(FLERR,
                   "Pair style gran/hysteretic: min_style {} evaluates trial positions, each of which would change the "
                   "history with law {}: use min_style fire",
                   search, args.words.front());
    }
}

double PairGranHysteretic::init_one(int i, int j)
{
  const int n = atom_types + 1;
  LawArguments &args = coefficients[i * n + j];
  if (!setflag[i][j]) {
    if (!setflag[i][i] || !setflag[j][j])
      error->all(FLERR, "All pair coeffs are not set: gran/hysteretic has none for types {} and {}", i, j);
    const LawArguments &a = coefficients[i * n + i], &b = coefficients[j * n + j];
    if (!a.same_options(b))
      error->all(FLERR, "Types {} and {} have different laws or options for identical spheres: give pair_coeff {} {}", i, j,
                 i, j);
    args = a;
    args.second = b.first;
  }
  const Material second = args.second.value_or(args.first);
  law(i, j) = args.contact(args.first, second);
  law(j, i) = args.contact(second, args.first);
  coefficients[j * n + i] = args;
  return init_shape(i, j);
}

PairGranHysteretic::PairParameters PairGranHysteretic::pair_parameters(int itype, int jtype, double ri, double rj)
{
  const LawArguments &args = coefficients[itype * (atom_types + 1) + jtype];
  const ContactLaw &contact_law = law(itype, jtype);
  PairParameters p;
  p.radius_i = ri;
  p.radius_j = rj;
  p.radsum = ri + rj;
  p.touch_sq = TouchingPairs::touch_squared(p.radsum);
  p.largest_overlap = largest_overlap(ri, rj);
  p.contact = scaled_law(itype, jtype, ri, rj);
  p.root_radius = std::sqrt(p.contact.effective_radius());
  if (has_special) p.largest_overlap = std::min(p.largest_overlap, p.contact.largest_overlap());
  p.friction = ri > 0.0 && rj > 0.0 ? args.friction : 0.0;
  p.shear_stiffness = contact_law.tangential_stiffness(1.0);
  p.tangential_model = args.tangential;
  p.loss = args.loss;
  if (args.resistance && ri > 0.0 && rj > 0.0) p.resistance = &args.resistance;
  return p;
}

/* Set the parameters of the pairs as far as they are the same in all steps: of all pairs if all spheres are equal, and by types
   if spheres of a type are. */
void PairGranHysteretic::set_parameters()
{
  parameters_by_type.clear();
  if (radii_vary) return;
  if (uniform) {
    batch.parameters[0] = pair_parameters(atom->type[0], atom->type[0], atom->radius[0], atom->radius[0]);
    for (int m = 0; m < Batch::CAPACITY; m++) batch.set(m, batch.parameters[0]);
    return;
  }
  const int n = atom_types + 1;
  std::vector<double> radius(n, -1.0);    // of the spheres of a type
  for (int i = 0; i < atom->nlocal + atom->nghost; i++) {
    double &of_type = radius[atom->type[i]];
    if (of_type >= 0.0 && of_type != atom->radius[i]) return;
    of_type = atom->radius[i];
  }
  parameters_by_type.resize(n * n);
  for (int i = 1; i < n; i++)
    for (int j = 1; j < n; j++)
      if (radius[i] >= 0.0 && radius[j] >= 0.0 && radius[i] + radius[j] > 0.0)
        parameters_by_type[i * n + j] = pair_parameters(i, j, radius[i], radius[j]);
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
    error->all(FLERR, "Restart file contains format {} of pair style gran/hysteretic; this version reads formats {} to {}",
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
  for (int i = 1; i <= atom_types; i++)
    for (int j = i; j <= atom_types; j++)
      if (setflag[i][j])
        text += fmt::format("{} {} {}\n", i, j, utils::join_words(coefficients[i * (atom_types + 1) + j].words, " "));
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
