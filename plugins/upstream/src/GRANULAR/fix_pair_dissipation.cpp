/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   Copyright (2003) Sandia Corporation.  Under the terms of Contract
   DE-AC04-94AL85000 with Sandia Corporation, the U.S. Government retains
   certain rights in this software.  This software is distributed under
   the GNU General Public License.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Energy that granular contacts take from the particles. Created by compute
   pair/dissipation/local.

   A step of velocity Verlet changes the kinetic energy of a particle by
   dt/2 (F.v at its start + F.v at its end), up to a term that is zero between
   two states in which it is free. F is therefore taken right after the pair
   style has computed it, and v at the end of the step.
------------------------------------------------------------------------- */

#include "fix_pair_dissipation.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "math_extra.h"
#include "memory.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using namespace FixConst;
using namespace MathExtra;

// extra values of Pair::single(): x component of the tangential force in all granular styles,
// and of the rolling force, and the twisting torque, in pair style granular

static constexpr int TANGENTIAL_FORCE = 0;
static constexpr int ROLLING_FORCE = 4;
static constexpr int TWISTING_TORQUE = 8;

// doubles per contact that are communicated

static constexpr int NPACK = 3 + 2 * FixPairDissipation::NCHANNEL;

/* ---------------------------------------------------------------------- */

FixPairDissipation::FixPairDissipation(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), pair(nullptr), granular(0), nghost_velocity(0), ghost_velocity(nullptr)
{
  if (narg != 3) error->all(FLERR, "Illegal fix PAIR_DISSIPATION command");
  if (!atom->radius_flag || !atom->omega_flag)
    error->all(FLERR, "Compute pair/dissipation/local requires atom attributes radius, omega");
  if (!atom->tag_enable) error->all(FLERR, "Compute pair/dissipation/local requires atom IDs");

  nevery = 1;
  comm_forward = 6;
  maxexchange_dynamic = 1;
  maxexchange = 1;
  create_attribute = 1;
  std::fill_n(total, NCHANNEL, 0.0);
  std::fill_n(last_total_rate, NCHANNEL, 0.0);

  FixPairDissipation::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
}

/* ---------------------------------------------------------------------- */

FixPairDissipation::~FixPairDissipation()
{
  if (copymode) return;
  atom->delete_callback(id, Atom::GROW);
  memory->destroy(ghost_velocity);
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::setmask() { return PRE_EXCHANGE | POST_FORCE | END_OF_STEP | POST_RUN; }

/* ---------------------------------------------------------------------- */

void FixPairDissipation::init()
{
  pair = force->pair_match("^gran", 0);
  if (!pair)
    error->all(FLERR, Error::NOLASTLINE,
               "Compute pair/dissipation/local requires one granular pair style");
  if (!pair->single_enable)
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {} does not support compute pair/dissipation/local", force->pair_style);
  if (!utils::strmatch(update->integrate_style, "^verlet"))
    error->all(FLERR, Error::NOLASTLINE,
               "Compute pair/dissipation/local does not support run style {}",
               update->integrate_style);
  granular = (force->pair_match("^granular", 0) == pair) ? 1 : 0;
  if (pair->single_extra <= (granular ? TWISTING_TORQUE : TANGENTIAL_FORCE + 2))
    error->all(FLERR, Error::NOLASTLINE,
               "Pair style {} does not support compute pair/dissipation/local", force->pair_style);
}

/* ----------------------------------------------------------------------
   rates at the first step of a run
------------------------------------------------------------------------- */

void FixPairDissipation::setup(int vflag)
{
  post_force(vflag);
  advance(0.0);
}

/* ----------------------------------------------------------------------
   forces between touching pairs, as the pair style has just applied them
------------------------------------------------------------------------- */

void FixPairDissipation::post_force(int /*vflag*/)
{
  double **x = atom->x;
  double *radius = atom->radius;
  int *mask = atom->mask;
  int *type = atom->type;
  NeighList *list = pair->list;

  touches.clear();
  Touch touch;

  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    if (!(mask[i] & groupbit)) continue;
    const int *jlist = list->firstneigh[i];

    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const double factor_lj = force->special_lj[jlist[jj] >> SBBITS & 3];
      const int j = jlist[jj] & NEIGHMASK;
      if (factor_lj == 0.0 || !(mask[j] & groupbit)) continue;

      const double rsq = distsq3(x[i], x[j]);
      const double radsum = radius[i] + radius[j];
      if (rsq >= radsum * radsum) {
        if (!pair->beyond_contact || rsq >= pair->cutsq[type[i]][type[j]]) continue;
      }
      if (evaluate(i, j, rsq, factor_lj, touch)) touches.push_back(touch);
    }
  }
}

/* ----------------------------------------------------------------------
   force between I and J by channel, return false if there is none
------------------------------------------------------------------------- */

bool FixPairDissipation::evaluate(int i, int j, double rsq, double factor_lj, Touch &touch)
{
  const double radi = atom->radius[i];
  const double radj = atom->radius[j];
  const double r = sqrt(rsq);

  double fpair = 0.0;
  pair->single(i, j, atom->type[i], atom->type[j], rsq, 1.0, factor_lj, fpair);
  copy3(pair->svector + TANGENTIAL_FORCE, touch.ftangential);
  if (fpair == 0.0 && lensq3(touch.ftangential) == 0.0) return false;

  touch.i = i;
  touch.j = j;
  touch.owner = owns(i, j);
  sub3(atom->x[i], atom->x[j], touch.normal);
  scale3(1.0 / r, touch.normal);

  // styles gran/* apply the tangential force at the surface of the undeformed particle,
  // style granular in the middle of the overlap

  const double half = granular ? 0.5 * (radi + radj - r) : 0.0;
  touch.leveri = radi - half;
  touch.leverj = radj - half;

  zero3(touch.rolling);
  touch.twisting = 0.0;
  if (granular) {
    cross3(touch.normal, pair->svector + ROLLING_FORCE, touch.rolling);
    scale3(radi * radj / (radi + radj), touch.rolling);
    touch.twisting = pair->svector[TWISTING_TORQUE];
  }

  touch.fnormal = fpair * r;
  return true;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::end_of_step() { advance(0.5 * update->dt); }

/* ----------------------------------------------------------------------
   integrate over a step by the trapezoidal rule, and forget contacts that have opened
------------------------------------------------------------------------- */

void FixPairDissipation::advance(double half_step)
{
  const int nlocal = atom->nlocal;
  const tagint *tag = atom->tag;

  communicate_velocities();

  double rate[NCHANNEL];
  double total_rate[NCHANNEL] = {};
  for (const auto &touch : touches) {
    rates_of(touch, rate);
    Contact &contact = record_of(touch.i, tag[touch.j]);
    integrate(contact, rate, half_step);
    contact.owner = touch.owner;
    if (touch.owner)
      for (int k = 0; k < NCHANNEL; k++) total_rate[k] += rate[k];

    if (touch.j < nlocal) {
      Contact &other = record_of(touch.j, tag[touch.i]);
      integrate(other, rate, half_step);
      other.owner = 0;
    }
  }

  for (int k = 0; k < NCHANNEL; k++) {
    total[k] += half_step * (last_total_rate[k] + total_rate[k]);
    last_total_rate[k] = total_rate[k];
  }

  const bigint step = update->ntimestep;
  for (int i = 0; i < nlocal; i++) {
    auto &list = contacts[i];
    const auto opened = [step](const Contact &contact) { return contact.step != step; };
    list.erase(std::remove_if(list.begin(), list.end(), opened), list.end());
  }
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::integrate(Contact &contact, const double *rate, double half_step) const
{
  contact.step = update->ntimestep;
  for (int k = 0; k < NCHANNEL; k++) {
    contact.energy[k] += half_step * (contact.rate[k] + rate[k]);
    contact.rate[k] = rate[k];
  }
}

/* ----------------------------------------------------------------------
   record of the contact of atom I with PARTNER, a new one if it has none
------------------------------------------------------------------------- */

FixPairDissipation::Contact &FixPairDissipation::record_of(int i, tagint partner)
{
  auto &list = contacts[i];
  for (auto &contact : list)
    if (contact.partner == partner) return contact;
  list.push_back({partner, 0, 0, {}, {}});
  return list.back();
}

/* ----------------------------------------------------------------------
   power that the contact takes from the two particles, by channel
------------------------------------------------------------------------- */

void FixPairDissipation::rates_of(const Touch &touch, double *rate) const
{
  const int nlocal = atom->nlocal;
  const double *vi = atom->v[touch.i];
  const double *omegai = atom->omega[touch.i];
  const bool ghost = touch.j >= nlocal;
  const double *vj = ghost ? ghost_velocity[touch.j - nlocal] : atom->v[touch.j];
  const double *omegaj = ghost ? ghost_velocity[touch.j - nlocal] + 3 : atom->omega[touch.j];

  double vrel[3], spin[3], torque[3], relrot[3];
  sub3(vi, vj, vrel);
  sub3(omegai, omegaj, relrot);
  scaleadd3(touch.leveri, omegai, touch.leverj, omegaj, spin);
  cross3(touch.normal, touch.ftangential, torque);

  rate[NORMAL] = -touch.fnormal * dot3(vrel, touch.normal);
  rate[TANGENTIAL] = dot3(torque, spin) - dot3(touch.ftangential, vrel);
  rate[ROLLING] = -dot3(touch.rolling, relrot);
  rate[TWISTING] = -touch.twisting * dot3(touch.normal, relrot);
}

/* ----------------------------------------------------------------------
   1 if the contact counts on this processor: with newton off, both that own one
   of its atoms compute it; the choice is that of compute pair/local
------------------------------------------------------------------------- */

int FixPairDissipation::owns(int i, int j) const
{
  if (force->newton_pair || j < atom->nlocal) return 1;
  const tagint itag = atom->tag[i];
  const tagint jtag = atom->tag[j];
  const bool odd = (itag + jtag) % 2 == 1;
  if (itag > jtag) return odd ? 1 : 0;
  return odd ? 0 : 1;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::communicate_velocities()
{
  if (atom->nghost > nghost_velocity) {
    nghost_velocity = atom->nghost;
    memory->destroy(ghost_velocity);
    memory->create(ghost_velocity, nghost_velocity, comm_forward, "fix:ghost_velocity");
  }
  comm->forward_comm(this);
}

/* ----------------------------------------------------------------------
   velocity of an owned atom or of a ghost that is sent on
------------------------------------------------------------------------- */

int FixPairDissipation::pack_forward_comm(int n, int *list, double *buf, int pbc_flag, int *pbc)
{
  // images in a deforming box move with it

  double shift[3] = {0.0, 0.0, 0.0};
  if (pbc_flag && domain->deform_vremap) {
    const double *h_rate = domain->h_rate;
    shift[0] = pbc[0] * h_rate[0] + pbc[5] * h_rate[5] + pbc[4] * h_rate[4];
    shift[1] = pbc[1] * h_rate[1] + pbc[3] * h_rate[3];
    shift[2] = pbc[2] * h_rate[2];
  }

  int m = 0;
  for (int k = 0; k < n; k++) {
    const int j = list[k];
    const bool ghost = j >= atom->nlocal;
    const double *v = ghost ? ghost_velocity[j - atom->nlocal] : atom->v[j];
    const double *omega = ghost ? ghost_velocity[j - atom->nlocal] + 3 : atom->omega[j];
    const bool moves = atom->mask[j] & domain->deform_groupbit;
    for (int d = 0; d < 3; d++) buf[m++] = v[d] + (moves ? shift[d] : 0.0);
    for (int d = 0; d < 3; d++) buf[m++] = omega[d];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::unpack_forward_comm(int n, int first, double *buf)
{
  for (int i = first; i < first + n; i++)
    for (int d = 0; d < comm_forward; d++) ghost_velocity[i - atom->nlocal][d] = *buf++;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::post_run() { pre_exchange(); }

/* ----------------------------------------------------------------------
   give every owned atom the records of all its contacts, which migrate with it; only with
   newton on does it lack some, of contacts that other processors or images computed
------------------------------------------------------------------------- */

void FixPairDissipation::pre_exchange()
{
  const int nlocal = atom->nlocal;

  if (force->newton_pair) {
    for (int i = nlocal; i < (int) contacts.size(); i++) contacts[i].clear();
    for (const auto &touch : touches) {
      if (touch.j < nlocal) continue;
      Contact contact = record_of(touch.i, atom->tag[touch.j]);
      contact.partner = atom->tag[touch.i];
      contact.owner = 0;
      contacts[touch.j].push_back(contact);
    }
    comm->reverse_comm_variable(this);
    touches.clear();
  }

  std::size_t most = 0;
  for (int i = 0; i < nlocal; i++) most = std::max(most, contacts[i].size());
  maxexchange = 1 + NPACK * (int) most;
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::pack_reverse_comm_size(int n, int first)
{
  int m = n;
  for (int i = first; i < first + n; i++) m += NPACK * (int) contacts[i].size();
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::pack_reverse_comm(int n, int first, double *buf)
{
  int m = 0;
  for (int i = first; i < first + n; i++) m += pack_contacts(i, buf + m);
  return m;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::unpack_reverse_comm(int n, int *list, double *buf)
{
  int m = 0;
  for (int k = 0; k < n; k++) m += unpack_contacts(list[k], buf + m);
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::pack_exchange(int i, double *buf) { return pack_contacts(i, buf); }

/* ---------------------------------------------------------------------- */

int FixPairDissipation::unpack_exchange(int nlocal, double *buf)
{
  contacts[nlocal].clear();
  return unpack_contacts(nlocal, buf);
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::pack_contacts(int i, double *buf) const
{
  int m = 0;
  buf[m++] = ubuf((bigint) contacts[i].size()).d;
  for (const auto &contact : contacts[i]) {
    buf[m++] = ubuf(contact.partner).d;
    buf[m++] = ubuf(contact.step).d;
    buf[m++] = ubuf(contact.owner).d;
    for (int k = 0; k < NCHANNEL; k++) buf[m++] = contact.rate[k];
    for (int k = 0; k < NCHANNEL; k++) buf[m++] = contact.energy[k];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int FixPairDissipation::unpack_contacts(int i, const double *buf)
{
  int m = 0;
  const int n = (int) ubuf(buf[m++]).i;
  for (int c = 0; c < n; c++) {
    Contact contact;
    contact.partner = (tagint) ubuf(buf[m++]).i;
    contact.step = (bigint) ubuf(buf[m++]).i;
    contact.owner = (int) ubuf(buf[m++]).i;
    for (int k = 0; k < NCHANNEL; k++) contact.rate[k] = buf[m++];
    for (int k = 0; k < NCHANNEL; k++) contact.energy[k] = buf[m++];
    contacts[i].push_back(contact);
  }
  return m;
}

/* ---------------------------------------------------------------------- */

void FixPairDissipation::grow_arrays(int n) { contacts.resize(n); }

/* ---------------------------------------------------------------------- */

void FixPairDissipation::copy_arrays(int i, int j, int /*delflag*/) { contacts[j] = contacts[i]; }

/* ---------------------------------------------------------------------- */

void FixPairDissipation::set_arrays(int i) { contacts[i].clear(); }

/* ---------------------------------------------------------------------- */

double FixPairDissipation::memory_usage()
{
  double bytes = (double) contacts.capacity() * sizeof(std::vector<Contact>);
  for (const auto &list : contacts) bytes += (double) list.capacity() * sizeof(Contact);
  bytes += (double) touches.capacity() * sizeof(Touch);
  bytes += (double) nghost_velocity * comm_forward * sizeof(double);
  return bytes;
}
