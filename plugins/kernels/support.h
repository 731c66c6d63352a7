// SPDX-License-Identifier: GPL-2.0-only
/* Support of a movable plane wall: a node or an elastic bar along the normal of the plane. No LAMMPS types.

     support MASS STIFFNESS DAMPING                  M u" + C u' + K u = F, or with MASS 0  C u' + K u = F
     support bar ELEMENTS MASS STIFFNESS END         lumped masses joined by springs; END = free | fixed | impedance
     support damper DAMPING                          F = F0 + C u', with the force F0 that it bears when the run begins
     support free MASS VELOCITY                      M u" = F, u' = -VELOCITY at the start: a plate that moves towards the spheres

   u is the outward displacement of the plane, away from the spheres; F >= 0 is their normal force on it. Both kinds are a chain
   of nodes that starts at the plane; the last node has a spring and a damper to the ground:

     m_i a_i = k (u_(i-1) - 2 u_i + u_(i+1)),   first: F,   last: - K u - C v

   A bar of N elements has masses M/N, half of that at its ends; with a fixed end the last element is the spring to the
   ground.

   Integration by velocity Verlet, together with the spheres: advance() moves the plane to the position at which the forces of
   this step are evaluated, push() sets their sum, finish() completes the step. The damper force is included in both half
   kicks, with the velocity before and after the step: second order, and for any damper stable up to the critical timestep
   without damper. Without mass the step is C (u1-u0)/dt + K (u0+u1)/2 = (3 F0 - F(-1))/2 (Adams-Bashforth for the force,
   which is not yet known at u1). */

#ifndef GRANWAVE_SUPPORT_H
#define GRANWAVE_SUPPORT_H

#include "../laws/material.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace granwave {

class Support {
 public:
  /* Parse the words after `support`; sets `used` to their number. Throws std::invalid_argument. */
  Support(const std::vector<std::string> &words, std::size_t &used)
  {
    const bool bar = !words.empty() && words[0] == "bar", plate = !words.empty() && words[0] == "free";
    bears_ = !words.empty() && words[0] == "damper";
    used = bar ? 5 : bears_ ? 2 : 3;
    if (words.size() < used) refuse("found " + std::to_string(words.size()) + " arguments");
    if (bar) {
      const double elements = number(words[1], "ELEMENTS"), total = number(words[2], "MASS");
      if (elements != std::floor(elements) || elements < 1 || elements > MOST_ELEMENTS)
        refuse("ELEMENTS must be a whole number from 1 to " + std::to_string(MOST_ELEMENTS) + ", found '" + words[1] + "'");
      stiffness_ = number(words[3], "STIFFNESS");
      is_bar_ = true;
      total_ = total;
      if (total == 0.0) refuse("MASS of a bar must be positive, found '" + words[2] + "'");
      if (stiffness_ == 0.0) refuse("STIFFNESS of a bar's element must be positive, found '" + words[3] + "'");
      const auto n = static_cast<std::size_t>(elements);
      const bool fixed = words[4] == "fixed";
      mass_.assign(fixed ? n : n + 1, total / elements);
      mass_.front() *= 0.5;
      if (fixed) {
        ground_stiffness_ = stiffness_;
      } else {
        mass_.back() *= 0.5;
        if (words[4] != "free") ground_damping_ = number(words[4], "END of a bar, unless free or fixed,");
      }
    } else if (plate) {
      mass_ = {number(words[1], "MASS of a free plate")};
      if (mass_[0] == 0.0) refuse("MASS of a free plate must be positive, found '" + words[1] + "'");
      launch_ = number(words[2], "VELOCITY of a free plate");
    } else if (bears_) {
      mass_ = {0.0};
      ground_damping_ = number(words[1], "DAMPING of a damper");
      if (ground_damping_ == 0.0) refuse("DAMPING of a damper must be positive, found '" + words[1] + "'");
    } else {
      mass_ = {number(words[0], "MASS")};
      ground_stiffness_ = number(words[1], "STIFFNESS");
      ground_damping_ = number(words[2], "DAMPING");
      if (ground_damping_ == 0.0) {
        if (ground_stiffness_ == 0.0) refuse("STIFFNESS and DAMPING are both 0, so the plane has no support");
        if (mass_[0] == 0.0) refuse("MASS and DAMPING are both 0, so the motion is undefined");
      }
    }
    place_.assign(mass_.size(), 0.0);
    speed_.assign(mass_.size(), 0.0 - launch_);
  }

  /* Critical timestep of the support, together with contacts of the given total stiffness. */
  double critical_timestep(double contacts = 0.0) const
  {
    const double ground = mass_.size() == 1 ? ground_stiffness_ : 0.0;
    if (massless()) return contacts > 0.0 ? ground_damping_ / contacts : INFINITE;
    const double spring = mass_.size() == 1 ? 0.0 : stiffness_;
    const double of_plane = 2.0 * std::sqrt(mass_[0] / (ground + spring + contacts));
    // chain of equal masses with halves at its ends: the highest frequency is 2 sqrt(k/m)
    const double of_chain = mass_.size() > 1 ? std::sqrt(2.0 * mass_[0] / stiffness_) : INFINITE;
    return std::min(of_plane, of_chain);
  }

  /* Mass with which the support resists a contact of a sphere of this mass, of the given stiffness; infinite if the plane is
     the surface of a body that the ground holds or that has no end. At the frequency w = sqrt(k/m) of the sphere on a plane at
     rest a node counts with M + C/w + K/w^2: a plate with its mass, and as held where its spring or damper hold it. */
  double moved_mass(double sphere, double stiffness) const
  {
    if (massless() || !(stiffness > 0.0)) return INFINITE;
    if (is_bar_) return ground_stiffness_ == 0.0 && ground_damping_ == 0.0 ? total_ : INFINITE;
    const double slowness = sphere / stiffness;    // 1/w^2
    return mass_[0] + ground_damping_ * std::sqrt(slowness) + ground_stiffness_ * slowness;
  }

  /* -------------------------------------------------------------------------- one step */

  void advance(double dt)
  {
    before_ = speed_.back();
    const double first = place_.front(), last = place_.back();
    if (massless()) {
      const double ahead = 1.5 * force_ - 0.5 * earlier_ - borne_, half = 0.5 * ground_stiffness_;
      place_[0] = (first * (ground_damping_ / dt - half) + ahead) / (ground_damping_ / dt + half);
    } else {
      kick(dt);
      speed_.back() -= 0.5 * dt * ground_damping_ * before_ / mass_.back();
      for (std::size_t i = 0; i < place_.size(); i++) place_[i] += dt * speed_[i];
    }
    earlier_ = force_;
    plane_moved_ = place_.front() - first;
    end_moved_ = place_.back() - last;
  }

  /* Set the force of the spheres on the plane at its present position. */
  void push(double force)
  {
    if (!started_) earlier_ = force;
    if (!started_ && bears_) borne_ = force;
    started_ = true;
    force_ = force;
    if (massless()) speed_[0] = (force_ - borne_ - ground_stiffness_ * place_[0]) / ground_damping_;
  }

  void finish(double dt)
  {
    if (!massless()) {
      kick(dt);
      speed_.back() /= 1.0 + 0.5 * dt * ground_damping_ / mass_.back();
    }
    work_ += 0.5 * (earlier_ + force_) * plane_moved_;
    damped_ += 0.5 * ground_damping_ * (before_ + speed_.back()) * end_moved_;
  }

  /* Make a Newton step of a minimization towards static equilibrium, with the spheres at their present positions. A support
     without a spring to the ground does not move; a free plate is launched when the run begins. */
  void settle(double contacts)
  {
    started_ = false;    // the next run has no previous step
    std::fill(speed_.begin(), speed_.end(), 0.0 - launch_);
    if (ground_stiffness_ == 0.0) return;
    const auto n = static_cast<double>(place_.size());
    const double whole = ground_stiffness_ / n;    // all springs of a bar are equal, including the spring to the ground
    const double front = place_[0] + (force_ - whole * place_[0]) / (whole + contacts);
    for (std::size_t i = 0; i < place_.size(); i++) place_[i] = front * (1.0 - static_cast<double>(i) / n);
  }

  /* -------------------------------------------------------------------------- output */

  double displacement() const { return place_.front(); }
  double velocity() const { return speed_.front(); }
  double work() const { return work_; }
  double damped() const { return damped_; }
  double force_on_ground() const { return borne_ + ground_stiffness_ * place_.back() + ground_damping_ * speed_.back(); }
  double energy() const
  {
    double sum = ground_stiffness_ * place_.back() * place_.back();
    for (std::size_t i = 0; i < place_.size(); i++) sum += mass_[i] * speed_[i] * speed_[i];
    for (std::size_t i = 0; i + 1 < place_.size(); i++)
      sum += stiffness_ * (place_[i + 1] - place_[i]) * (place_[i + 1] - place_[i]);
    return 0.5 * sum + borne_ * place_.back();
  }

  /* Add force times velocity, and force^2 / mass, of all nodes; forces without the damper. */
  void add_power(double &power, double &force_squared_over_mass) const
  {
    if (massless()) return;
    double pull = force_;
    for (std::size_t i = 0; i < place_.size(); i++) {
      const double on = force_behind(i), total = pull - on;
      power += total * speed_[i];
      force_squared_over_mass += total * total / mass_[i];
      pull = on;
    }
  }

  /* Set the initial velocity of a plate towards the spheres. Returns false if the support is not a plate. */
  bool launch(double velocity)
  {
    if (mass_.size() > 1 || ground_stiffness_ > 0.0 || ground_damping_ > 0.0) return false;
    launch_ = velocity;
    speed_[0] = -velocity;
    return true;
  }

  /* Reset work and damper loss to zero. */
  void begin() { work_ = damped_ = 0.0; }

  /* -------------------------------------------------------------------------- restart */

  std::vector<double> state() const
  {
    std::vector<double> all{started_ ? 1.0 : 0.0, force_, earlier_, work_, damped_};
    all.insert(all.end(), place_.begin(), place_.end());
    all.insert(all.end(), speed_.begin(), speed_.end());
    if (bears_) all.push_back(borne_);
    return all;
  }

  std::size_t state_size() const { return N_STATE + 2 * place_.size() + (bears_ ? 1 : 0); }

  void restore(const double *all)
  {
    started_ = all[0] != 0.0;
    const double *sum = all + 1;
    for (double *number : {&force_, &earlier_, &work_, &damped_}) *number = *sum++;
    std::copy_n(all + N_STATE, place_.size(), place_.begin());
    std::copy_n(all + N_STATE + place_.size(), speed_.size(), speed_.begin());
    if (bears_) borne_ = all[N_STATE + 2 * place_.size()];
  }

  bool massless() const { return mass_[0] == 0.0; }

 private:
  static constexpr int MOST_ELEMENTS = 1000000;
  static constexpr std::size_t N_STATE = 5;

  std::vector<double> mass_, place_, speed_;    // displacement and velocity of each node, starting at the plane
  double stiffness_ = 0.0;                      // stiffness of each spring between two nodes
  double ground_stiffness_ = 0.0, ground_damping_ = 0.0;
  double launch_ = 0.0;                   // initial speed of a free plate towards the spheres
  double force_ = 0.0, earlier_ = 0.0;    // force of the spheres, in this evaluation and in the previous step
  double borne_ = 0.0;                    // constant force of the ground on a damper
  double work_ = 0.0, damped_ = 0.0;
  double total_ = 0.0;    // mass of a bar
  bool is_bar_ = false;
  bool bears_ = false;
  bool started_ = false;
  double before_ = 0.0, plane_moved_ = 0.0, end_moved_ = 0.0;    // in this step

  /* Force of a node on the next node or the ground. */
  double force_behind(std::size_t i) const
  {
    return i + 1 == place_.size() ? ground_stiffness_ * place_[i] : stiffness_ * (place_[i] - place_[i + 1]);
  }

  /* Half kick by springs and force, without the damper. */
  void kick(double dt)
  {
    double pull = force_;    // force of the previous node on this one
    for (std::size_t i = 0; i < place_.size(); i++) {
      const double on = force_behind(i);
      speed_[i] += 0.5 * dt * (pull - on) / mass_[i];
      pull = on;
    }
  }

  [[noreturn]] static void refuse(const std::string &what)
  {
    throw std::invalid_argument(
        "support: " + what +
        "; expected support MASS STIFFNESS DAMPING (MASS may be 0 with DAMPING), "
        "support bar ELEMENTS MASS STIFFNESS free|fixed|IMPEDANCE, support damper DAMPING, or support free MASS VELOCITY");
  }

  static double number(const std::string &word, const std::string &what)
  {
    char *end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end || !std::isfinite(value) || value < 0.0)
      refuse(what + " must be a number, 0 or more, found '" + word + "'");
    return value;
  }
};

}    // namespace granwave

#endif
