// SPDX-License-Identifier: GPL-2.0-only
#include "gran_dents.h"

#include "comm.h"
#include "compute.h"
#include "domain.h"
#include "error.h"
#include "fix_wall_gran_hysteretic.h"
#include "force.h"
#include "modify.h"
#include "motion.h"
#include "neighbor.h"
#include "pair_gran_hysteretic.h"

#if defined(MPI_STUBS) && !defined(MPI_BOR)
#define MPI_BOR MPI_LOR    // older stubs for one process lack it; they combine nothing
#endif

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr std::size_t N_DENT = 3, N_SPRING = 4, N_PLACE = 2;    // words of a line: a dent, and what may follow

enum { FIRST_SEEN = 1, SECOND_SEEN = 2 };    // status of a line together with DentStatus, combined over processors

bool is_id(const std::string &word)
{
  return !word.empty() && word.size() < 16 && word.find_first_not_of("0123456789") == std::string::npos;
}

constexpr const char *OTHER =
    "the contact has another law, friction, loss or resistance in this file than in the input script";

/* Fill in a contact from its numbers, the peak first; returns false if there are too few. */
bool complete(KnownContact &contact, const std::vector<double> &values, bool on_wall)
{
  const std::size_t n_place = on_wall ? N_PLACE : 0;
  if (values.size() < 1 + N_SPRING + n_place || values[N_SPRING] < 0.0) return false;
  auto at = values.begin() + 1;
  contact.whole = true;
  std::copy_n(at, 3, contact.force);
  contact.compliance = values[N_SPRING];
  at += N_SPRING;
  std::copy_n(at, n_place, contact.place);
  contact.block.assign(at + n_place, values.end());
  return true;
}

}    // namespace

void GranDents::command(int narg, char **arg)
{
  const std::string word = narg > 0 ? arg[0] : "";
  const bool alone = word == "begin" || word == "clear";
  if (!(alone && narg == 1) && !(word == "read" && narg == 2))
    error->all(FLERR, "Illegal {} command: expected 'read FILE', 'begin' or 'clear'", STYLE);
  if (!domain->box_exist) error->all(FLERR, "Command {} before the simulation box is defined", STYLE);
  pair = dynamic_cast<PairGranHysteretic *>(force->pair_match(PairGranHysteretic::STYLE, 1));
  if (!pair) error->all(FLERR, "Command {} requires pair style {}", STYLE, PairGranHysteretic::STYLE);
  build_lists();
  pair->prepare_initial_dents();
  if (word == "read") set(arg[1], read(arg[1]));
  else begin(word == "begin");
  for (auto *compute : modify->get_compute_list())
    compute->invoked_flag = 0;    // their values of this timestep are outdated
}

/* Begin anew with the dents so far, or without any. */
void GranDents::begin(bool keeps)
{
  pair->begin_initial_dents(keeps);
  for (auto *fix : modify->get_fix_list())
    if (auto *wall = dynamic_cast<FixWallGranHysteretic *>(fix)) wall->begin(keeps);
}

/* Build ghost atoms and neighbor lists as at the start of a run. */
void GranDents::build_lists()
{
  lmp->init();
  modify->setup_pre_exchange();
  if (domain->triclinic) domain->x2lamda(atom->nlocal);
  domain->pbc();
  domain->reset_box();
  comm->setup();
  if (neighbor->style) neighbor->setup_bins();
  comm->exchange();
  comm->borders();
  if (domain->triclinic) domain->lamda2x(atom->nlocal + atom->nghost);
  neighbor->build(1);
  if (domain->triclinic) comm->forward_comm();    // ghosts are shifted as in a run
}

std::vector<GranDents::Line> GranDents::read(const std::string &file)
{
  std::vector<Line> lines;
  for (const auto &[number, text, w] : read_rows(lmp, file, fmt::format("{}: cannot read file {}", STYLE, file))) {
    const auto wrong = [&, number = number, &text = text](const std::string &what) {
      error->all(FLERR, "{}: line {} of {}: {}, found '{}'", STYLE, number, file, what, text);
    };
    const auto id = [&](const std::string &word) {
      const long long value = std::stoll(word);
      if (value > MAXTAGINT) wrong("there is no sphere " + word);
      return static_cast<tagint>(value);
    };
    if (w.size() < N_DENT || !is_id(w[1]))
      wrong("expected 'i j peak' with the ids of two spheres, or 'FIXID i peak' of a wall");
    Line line{number, nullptr, 0, id(w[1]), {}};
    bool swapped = false;
    if (is_id(w[0])) {
      line.i = id(w[0]);
      if (line.i == line.j) wrong("a sphere has no contact with itself");
      swapped = line.i > line.j;
      if (swapped) std::swap(line.i, line.j);
    } else {
      line.wall = dynamic_cast<FixWallGranHysteretic *>(modify->get_fix_by_id(w[0]));
      if (!line.wall) wrong("there is no fix " + std::string(FixWallGranHysteretic::STYLE) + " with the ID '" + w[0] + "'");
    }
    std::vector<double> values;
    for (std::size_t k = N_DENT - 1; k < w.size(); k++) {
      char *end = nullptr;
      values.push_back(std::strtod(w[k].c_str(), &end));
      if (*end != '\0' || !std::isfinite(values.back()))
        wrong(k < N_DENT ? "the dent must be a number" : "the state of the contact must be numbers");
    }
    line.contact.peak = values[0];
    if (line.contact.peak < 0.0) wrong("the dent must not be negative");
    if (w.size() > N_DENT && !complete(line.contact, values, line.wall != nullptr))
      wrong(line.wall ? "expected 'FIXID i peak', or behind it fx fy fz compliance, two coordinates and a block"
                      : "expected 'i j peak', or behind it fx fy fz compliance and a block");
    for (double &force : line.contact.force) force *= swapped ? -1.0 : 1.0;
    lines.push_back(line);
  }
  return lines;
}

void GranDents::set(const std::string &file, const std::vector<Line> &lines)
{
  const auto wrong = [&](const Line &line, const std::string &what) {
    error->all(FLERR, "{}: line {} of {}: {}", STYLE, line.number, file, what);
  };
  std::map<PairGranHysteretic::Ids, int> pairs;    // line of each pair
  std::map<PairGranHysteretic::Ids, KnownContact> known;
  std::map<std::pair<FixWallGranHysteretic *, tagint>, int> on_walls;
  std::map<tagint, int> owned;
  for (int i = 0; i < atom->nlocal; i++) owned[atom->tag[i]] = i;
  std::vector<int> mine(lines.size(), 0), state(lines.size(), 0);
  for (int k = 0; k < static_cast<int>(lines.size()); k++) {
    const Line &line = lines[k];
    const bool fresh = line.wall ? on_walls.emplace(std::pair(line.wall, line.j), k).second
                                 : pairs.emplace(std::pair(line.i, line.j), k).second;
    if (!fresh) wrong(line, "this contact was given before");
    if (!line.wall) known[{line.i, line.j}] = line.contact;
    if (owned.count(line.i)) mine[k] |= FIRST_SEEN;
    const auto found = owned.find(line.j);
    if (found == owned.end()) continue;
    mine[k] |= SECOND_SEEN;
    if (line.wall && line.contact.peak > atom->radius[found->second]) mine[k] |= PairGranHysteretic::TOO_DEEP;
  }
  for (const auto &[ids, status] : pair->set_contacts(known)) mine[pairs[ids]] |= status;
  MPI_Allreduce(mine.data(), state.data(), static_cast<int>(lines.size()), MPI_INT, MPI_BOR, world);

  for (int k = 0; k < static_cast<int>(lines.size()); k++) {
    const Line &line = lines[k];
    if (!line.wall && !(state[k] & FIRST_SEEN)) wrong(line, fmt::format("there is no sphere {}", line.i));
    if (!(state[k] & SECOND_SEEN)) wrong(line, fmt::format("there is no sphere {}", line.j));
    if (state[k] & PairGranHysteretic::TOO_DEEP)
      wrong(line, fmt::format("the dent, {:.6g}, exceeds the radius of the {}", line.contact.peak,
                              line.wall ? "sphere" : "smaller sphere"));
    if (state[k] & PairGranHysteretic::OTHER_LAW) wrong(line, OTHER);
    if (!line.wall && !(state[k] & PairGranHysteretic::SET))
      wrong(line, fmt::format("spheres {} and {} are farther apart than the gap beyond which an indentation is forgotten",
                              line.i, line.j));
    if (!line.wall || !owned.count(line.j)) continue;
    const int i = owned[line.j];
    if (!line.contact.whole) line.wall->set_dent(i, line.contact.peak);
    else if (!line.wall->set_contact(i, line.contact))
      error->one(FLERR, "{}: line {} of {}: {}", STYLE, line.number, file, OTHER);
  }
}
