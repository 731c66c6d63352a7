// SPDX-License-Identifier: GPL-2.0-only
#include "fix_gran_hysteretic_history.h"

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "motion.h"
#include "restart_state.h"

using namespace LAMMPS_NS;
using namespace granwave;

namespace {

// the state of a sphere: this head, sums over forgotten contacts if there are any, records with their blocks
enum { COUNT, OWNER, BIRTH, EXTRA, PARTS, SUMS, N_HEAD };

/* Number of the parts of a block behind the doubles of the law. Restart files of format 12 have both or none. */
int parts_of(const BlockLayout &layout)
{
  enum { NONE, BOTH, SPRING, DENT };
  if (layout.friction) return layout.dents ? BOTH : SPRING;
  return layout.dents ? DENT : NONE;
}

BlockLayout layout_of(int n_extra, int parts)
{
  for (const bool friction : {false, true})
    for (const bool dents : {false, true})
      if (const BlockLayout layout{n_extra, friction, dents}; parts_of(layout) == parts) return layout;
  return {n_extra};
}

}    // namespace

FixGranHystereticHistory::FixGranHystereticHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (std::strcmp(id, ID) != 0)
    error->all(FLERR, "Fix {} belongs to pair style gran/hysteretic and cannot be used by itself", STYLE);
  restart_peratom = restart_global = 1;
  comm_border = N_BORDER;
  create_attribute = 1;
  maxexchange_dynamic = 1;
  FixGranHystereticHistory::grow_arrays(atom->nmax);
  for (const int kind : {Atom::GROW, Atom::RESTART, Atom::BORDER}) atom->add_callback(kind);
}

FixGranHystereticHistory::~FixGranHystereticHistory()
{
  if (lose_contacts) lose_contacts();
  for (const int kind : {Atom::GROW, Atom::RESTART, Atom::BORDER}) atom->delete_callback(id, kind);
}

/* End the flat list of the pair style before spheres migrate. LAMMPS subsequently assigns spheres to
   subdomains and bins, where one whose position is not finite would be lost. */
void FixGranHystereticHistory::gather()
{
  require_finite_motion(lmp);
  if (suspend_contacts) suspend_contacts();
  // a sphere may be passed on by a processor on which it did not start
  maxexchange = most_numbers(in_list);
  MPI_Allreduce(MPI_IN_PLACE, &maxexchange, 1, MPI_INT, MPI_MAX, world);
}

void FixGranHystereticHistory::grow_arrays(int nmax)
{
  history.grow(nmax);
  images_.resize(nmax);
}

/* The new list of a minimization also begins with the initial histories. */
void FixGranHystereticHistory::min_pre_exchange()
{
  if (return_to_start) return_to_start();
  gather();
}

/* The callbacks below may be called by commands that reorder spheres at any time (sort, delete_atoms, fix balance),
   before gather() is called: the first call ends the list. */
void FixGranHystereticHistory::copy_arrays(int i, int j, int)
{
  if (suspend_contacts) suspend_contacts();
  history.copy(i, j);
  images_[j] = {};
}

void FixGranHystereticHistory::set_arrays(int i)
{
  if (suspend_contacts) suspend_contacts();
  history.forget_sphere(i);
  history.list(i, -1);
  history.set_birth(i, ++births << RANKS | comm->me);
  images_[i] = {};
}

/* Send ghosts the birth number of their sphere, and the periodic boundaries in between. */
int FixGranHystereticHistory::pack_border(int n, int *spheres, double *buf)
{
  double *at = buf;
  for (int k = 0; k < n; k++) {
    const int i = spheres[k];
    const Images images = i < atom->nlocal ? Images() : images_[i];
    *at++ = ubuf(history.birth(i)).d;
    at = std::copy_n(atom->x[i], 3, at);
    at = std::copy_n(images.along, 3, at);
  }
  return static_cast<int>(at - buf);
}

int FixGranHystereticHistory::unpack_border(int n, int first, double *buf)
{
  // in a triclinic box LAMMPS has them in units of its edges
  const double period[3] = {domain->triclinic ? 1.0 : domain->xprd, domain->triclinic ? 1.0 : domain->yprd,
                            domain->triclinic ? 1.0 : domain->zprd};
  const double *at = buf;
  for (int i = first; i < first + n; i++, at += N_BORDER) {
    history.set_birth(i, static_cast<std::int64_t>(ubuf(at[0]).i));
    const double *const of_sender = at + 1;
    for (int d = 0; d < 3; d++) {
      const double passed = std::round((atom->x[i][d] - of_sender[d]) / period[d]);
      images_[i].along[d] = static_cast<std::int8_t>(of_sender[3 + d] + passed);
    }
  }
  return static_cast<int>(at - buf);
}

/* Size of the state of sphere i with a number of additional records, and the largest size. */
int FixGranHystereticHistory::size(int i, int further) const
{
  return N_HEAD + (!history.has_forgotten(i) && further == 0 ? 0 : ForgottenContacts::SIZE) +
         (ContactRecord::SIZE + history.layout().size()) * (history.count(i) + further);
}

void FixGranHystereticHistory::expect_records(int n)
{
  in_list = n;
  maxexchange = std::max(maxexchange, most_numbers(n));
}

/* Give the records of all processors the same layout: those of a restart file are known only where there are atoms. */
void FixGranHystereticHistory::agree_on_layout()
{
  const BlockLayout mine = history.layout();
  int most[] = {mine.n_extra, mine.friction ? 1 : 0, mine.dents ? 1 : 0};
  MPI_Allreduce(MPI_IN_PLACE, most, 3, MPI_INT, MPI_MAX, world);
  history.extend({most[0], most[1] != 0, most[2] != 0});
}

int FixGranHystereticHistory::most_numbers(int further) const
{
  int most = N_HEAD;
  for (int i = 0; i < atom->nlocal; i++) most = std::max(most, size(i, further));
  return most;
}

int FixGranHystereticHistory::pack(int i, double *buf) const
{
  const BlockLayout &layout = history.layout();
  const ForgottenContacts sums = history.forgotten(i);
  buf[COUNT] = history.count(i);
  buf[OWNER] = ubuf(static_cast<int64_t>(history.owner(i))).d;
  buf[BIRTH] = ubuf(history.birth(i)).d;
  buf[EXTRA] = layout.n_extra;
  buf[PARTS] = parts_of(layout);
  buf[SUMS] = !sums.none();
  double *at = buf + N_HEAD;
  if (!sums.none()) at = to_doubles(sums, at);
  const ContactRecord *record = history.records(i);
  for (int k = 0; k < history.count(i); k++, record++) {
    at = to_doubles(*record, at);
    at = std::copy_n(history.block(i, k), layout.size(), at);
  }
  return static_cast<int>(at - buf);
}

int FixGranHystereticHistory::unpack(int i, const double *buf)
{
  const BlockLayout packed = layout_of(static_cast<int>(buf[EXTRA]), static_cast<int>(buf[PARTS]));
  const double *at = buf + N_HEAD;
  history.forget_sphere(i);
  history.list(i, -1);
  history.own(i, static_cast<std::int64_t>(ubuf(buf[OWNER]).i));
  history.set_birth(i, static_cast<std::int64_t>(ubuf(buf[BIRTH]).i));
  images_[i] = {};
  if (buf[SUMS] != 0.0) {
    history.forgotten_to_change(i) = from_doubles<ForgottenContacts>(at);
    at += ForgottenContacts::SIZE;
  }
  history.extend(packed);
  std::vector<double> block;
  for (int k = 0; k < static_cast<int>(buf[COUNT]); k++) {
    const ContactRecord record = from_doubles<ContactRecord>(at);
    at += ContactRecord::SIZE;
    block.assign(history.layout().size(), 0.0);
    ContactHistory::copy_block(packed, at, history.layout(), block.data());
    at += packed.size();
    history.append(i, record, block.data());
  }
  return static_cast<int>(at - buf);
}

int FixGranHystereticHistory::pack_exchange(int i, double *buf)
{
  if (suspend_contacts) suspend_contacts();
  if (hand_over_contacts) hand_over_contacts(i);
  return pack(i, buf);
}

int FixGranHystereticHistory::unpack_exchange(int nlocal, double *buf)
{
  if (suspend_contacts) suspend_contacts();
  return unpack(nlocal, buf);
}

int FixGranHystereticHistory::pack_restart(int i, double *buf)
{
  if (publish_contacts) publish_contacts();
  return seal_atom_state(lmp, i, buf, pack(i, buf + AtomState::HEAD));
}

void FixGranHystereticHistory::unpack_restart(int i, int nth) { unpack(i, atom_state(lmp, *this, i, nth).values); }

int FixGranHystereticHistory::size_restart(int i)
{
  if (publish_contacts) publish_contacts();
  return AtomState::HEAD + size(i, 0);
}

int FixGranHystereticHistory::maxsize_restart()
{
  if (publish_contacts) publish_contacts();
  int most = most_numbers(0);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, world);
  return AtomState::HEAD + most;    // the first processor writes it for the atoms of all
}

/* ---------------------------------------------------------------------- number of births, so that birth numbers after a restart are different */

void FixGranHystereticHistory::write_restart(FILE *fp)
{
  std::int64_t most = 0;
  MPI_Reduce(&births, &most, 1, MPI_LONG_LONG, MPI_MAX, 0, world);
  if (comm->me == 0) write_state(fp, {static_cast<double>(most)});
}

void FixGranHystereticHistory::restart(char *buffer)
{
  births = static_cast<std::int64_t>(read_state(lmp, *this, buffer, 1)[0]);
}
