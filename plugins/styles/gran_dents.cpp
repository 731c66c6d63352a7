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

#include <set>

#if defined(MPI_STUBS) && !defined(MPI_BOR)
#define MPI_BOR MPI_LOR    // missing in older stubs for one process, in which there is nothing to combine
#endif

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

constexpr std::size_t N_DENT = 3, N_SPRING = 4, N_PLACE = 2;    // words of a line: a dent, and optional values

enum { FIRST_SEEN = 1, SECOND_SEEN = 2 };    // spheres of a line, combined over processors

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
  pair = PairGranHysteretic::find(force);
  if (!pair) error->all(FLERR, "Command {} requires pair style {}", STYLE, PairGranHysteretic::STYLE);
  build_lists();
  pair->prepare_initial_dents();
  if (word == "read") read(arg[1]);
  else begin(word == "begin");
  for (auto *compute : modify->get_compute_list())
    compute->invoked_flag = 0;    // their values of this timestep are outdated
}

/* Restart the history with the present dents, or without dents. */
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

/* Read the file piece by piece. A processor keeps only the contacts of its own spheres. */
void GranDents::read(const std::string &file)
{
  Owned owned;    // no member: LAMMPS does not delete a command that ends in an error
  for (int i = 0; i < atom->nlocal; i++) owned[atom->tag[i]] = i;
  TextRows text(lmp, file, fmt::format("{}: cannot read file {}", STYLE, file));
  std::vector<TextRow> rows;
  std::vector<Line> mine;
  while (text.next(rows)) {
    std::vector<Line> lines;
    for (const TextRow &row : rows) lines.push_back(line_of(file, row));
    require_spheres(file, lines, owned);
    for (Line &line : lines)
      if (owned.count(line.j) || (!line.wall && owned.count(line.i))) mine.push_back(std::move(line));
  }
  set(file, mine, owned);
}

GranDents::Line GranDents::line_of(const std::string &file, const TextRow &row)
{
  const std::vector<std::string> &w = row.words;
  const auto wrong = [&](const std::string &what) {
    error->all(FLERR, "{}: line {} of {}: {}, found '{}'", STYLE, row.number, file, what, row.text);
  };
  const auto id = [&](const std::string &word) {
    const long long value = std::stoll(word);
    if (value > MAXTAGINT) wrong("there is no sphere " + word);
    return static_cast<tagint>(value);
  };
  if (w.size() < N_DENT || !is_id(w[1]))
    wrong("expected 'i j peak' with the ids of two spheres, or 'FIXID i peak' of a wall");
  Line line{row.number, nullptr, 0, id(w[1]), {}};
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
  return line;
}

/* Stop with an error if no processor has a sphere of these lines. */
void GranDents::require_spheres(const std::string &file, const std::vector<Line> &lines, const Owned &owned)
{
  const int n = static_cast<int>(lines.size());
  std::vector<int> mine(n, 0), seen(n, 0);
  for (int k = 0; k < n; k++)
    mine[k] = (lines[k].wall || owned.count(lines[k].i) ? FIRST_SEEN : 0) | (owned.count(lines[k].j) ? SECOND_SEEN : 0);
  MPI_Allreduce(mine.data(), seen.data(), n, MPI_INT, MPI_BOR, world);
  for (int k = 0; k < n; k++)
    if (seen[k] != (FIRST_SEEN | SECOND_SEEN))
      error->all(FLERR, "{}: line {} of {}: there is no sphere {}", STYLE, lines[k].number, file,
                 seen[k] & FIRST_SEEN ? lines[k].j : lines[k].i);
}

/* Set the contacts of the spheres of this processor. The first invalid line on any processor stops all. */
void GranDents::set(const std::string &file, std::vector<Line> &mine, const Owned &owned)
{
  std::set<Ids> pairs;
  std::set<std::pair<FixWallGranHysteretic *, tagint>> on_walls;
  std::map<Ids, KnownContact> known;
  bigint first = MAXBIGINT;
  std::string fault;
  for (Line &line : mine) {
    const bool fresh = line.wall ? on_walls.emplace(line.wall, line.j).second : pairs.emplace(line.i, line.j).second;
    if (!fresh && line.number < first) {
      first = line.number;
      fault = "this contact was given before";
    }
    if (!line.wall) known[{line.i, line.j}] = std::move(line.contact);
  }
  stop_at_first(file, first, fault);

  std::map<Ids, int> status;
  for (const auto &[ids, how] : pair->set_contacts(known)) status[ids] = how;
  known.clear();
  for (Line &line : mine) {
    const std::string found = fault_of(line, status, owned);
    if (found.empty() || line.number > first) continue;
    first = line.number;
    fault = found;
  }
  stop_at_first(file, first, fault);
}

/* Stop with an error if there is an invalid line on a processor. */
void GranDents::stop_at_first(const std::string &file, bigint first, std::string fault)
{
  bigint least;
  MPI_Allreduce(&first, &least, 1, MPI_LMP_BIGINT, MPI_MIN, world);
  if (least == MAXBIGINT) return;
  const int mine = first == least ? comm->me : comm->nprocs;
  int rank, length = static_cast<int>(fault.size());
  MPI_Allreduce(&mine, &rank, 1, MPI_INT, MPI_MIN, world);
  MPI_Bcast(&length, 1, MPI_INT, rank, world);
  fault.resize(length);
  MPI_Bcast(fault.data(), length, MPI_CHAR, rank, world);
  error->all(FLERR, "{}: line {} of {}: {}", STYLE, least, file, fault);
}

/* Return the fault of a line on the processor of its first sphere, empty if there is none; set the contact of a line with a wall. */
std::string GranDents::fault_of(const Line &line, const std::map<Ids, int> &status, const Owned &owned)
{
  const auto sphere = owned.find(line.wall ? line.j : line.i);
  if (sphere == owned.end()) return "";
  const double peak = line.contact.peak;
  const auto found = status.find({line.i, line.j});
  const int how = found == status.end() ? 0 : found->second;
  const bool too_deep = line.wall ? peak > atom->radius[sphere->second] : how & PairGranHysteretic::TOO_DEEP;
  if (too_deep)
    return fmt::format("the dent, {:.6g}, exceeds the radius of the {}", peak, line.wall ? "sphere" : "smaller sphere");
  if (how & PairGranHysteretic::OTHER_LAW) return OTHER;
  if (!line.wall && !(how & PairGranHysteretic::SET))
    return fmt::format("spheres {} and {} are farther apart than the gap beyond which an indentation is forgotten", line.i,
                       line.j);
  if (!line.wall) return "";
  if (line.contact.whole) return line.wall->set_contact(sphere->second, line.contact) ? "" : OTHER;
  line.wall->set_dent(sphere->second, peak);
  return "";
}
