// SPDX-License-Identifier: GPL-2.0-only
/* Load as a function of time. No LAMMPS types.

     half-sine    A sin(pi t/T)                                    0 <= t <= T, else 0
     rectangle    A                                                0 <= t <= T, else 0
     harmonic     A sin(2 pi f t)                                  from t = 0 on
     table        linear interpolation

   Smooth forms of many periods, where w(t) rises as sin^2(pi t/2R) over the ramp R, and falls likewise before T if there is an end:

     ramped       A w sin(2 pi f t)                                from t = 0 on
     burst        A sin^2(pi t/T) sin(2 pi f t)                    0 <= t <= T = n/f, else 0
     up-and-down  A (1 - |2t/T - 1|) sin(2 pi f t)                 0 <= t <= T, else 0
     sweep        A w sin(2 pi (f0 t + (f1 - f0) t^2/2T))          0 <= t <= T, else 0
     noise        A w sqrt(2/N) sum sin(2 pi f_k t + phase_k)      0 <= t <= T, else 0
                  f_k the N multiples of 1/T from f0 to f1, phases from a generator of random numbers  */

#ifndef GRANWAVE_LOAD_SHAPE_H
#define GRANWAVE_LOAD_SHAPE_H

#include "material.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace granwave {

class LoadShape {
 public:
  using Rows = std::vector<std::pair<double, double>>;    // time, value

  LoadShape() = default;

  /* At least two rows with increasing times are required; throws std::invalid_argument otherwise. */
  explicit LoadShape(Rows rows) : form_(Form::table), rows_(std::move(rows))
  {
    if (rows_.size() < 2)
      throw std::invalid_argument("it requires at least two rows, found " + std::to_string(rows_.size()));
    if (rows_[0].first < 0.0) throw std::invalid_argument("its first time is negative");
    before_.push_back(0.0);
    for (std::size_t k = 1; k < rows_.size(); k++) {
      const auto &[t, value] = rows_[k];
      const auto &[earlier, last] = rows_[k - 1];
      if (!(t > earlier))
        throw std::invalid_argument("its times must increase, and row " + std::to_string(k + 1) + " does not");
      before_.push_back(before_.back() + 0.5 * (value + last) * (t - earlier));
    }
  }

  /* Shape by its name in input scripts, with its numbers in the order of fix gran/load. Throws std::invalid_argument for another
     name, and for noise if no multiple of 1/duration lies between its frequencies. */
  static LoadShape named(const std::string &form, const std::vector<double> &is)
  {
    if (form == "half-sine") return {Form::half_sine, is.at(0), 0.0, 0.0, is.at(1), 0.0};
    if (form == "rectangle") return {Form::rectangle, is.at(0), 0.0, 0.0, is.at(1), 0.0};
    if (form == "harmonic" && is.size() == 2) return {Form::harmonic, is[0], is[1], is[1], 1.0 / is[1], 0.0};
    if (form == "harmonic") return {Form::ramped, is.at(0), is.at(1), is.at(1), HUGE_VAL, is.at(2)};
    if (form == "burst") return {Form::burst, is.at(0), is.at(1), is.at(1), is.at(2) / is.at(1), 0.0};
    if (form == "up-and-down") return {Form::up_and_down, is.at(0), is.at(1), is.at(1), is.at(2), 0.0};
    if (form == "sweep") return {Form::sweep, is.at(0), is.at(1), is.at(2), is.at(3), is.at(4)};
    if (form != "noise") throw std::invalid_argument("no shape of a load is called " + form);
    LoadShape noise(Form::noise, is.at(0), is.at(1), is.at(2), is.at(3), is.at(4));
    noise.set_phases(static_cast<std::uint64_t>(is.at(5)));
    return noise;
  }

  /* Integral of the force from a to b. The force is an even function of time. */
  double integral(double a, double b) const
  {
    if (!is_smooth()) return integral(b) - integral(a);
    return a < 0.0 ? smooth_integral(0.0, -a) + smooth_integral(0.0, b) : smooth_integral(a, b);
  }

  /* Force or displacement at a time; a table is constant before its first and after its last row. */
  double value(double t) const
  {
    if (is_smooth()) return t <= 0.0 || t >= duration_ ? 0.0 : amplitude_ * window(t) * wave(t);
    if (form_ == Form::half_sine || form_ == Form::rectangle) {
      if (t < 0.0 || t > duration_) return 0.0;
      return form_ == Form::rectangle ? amplitude_ : amplitude_ * std::sin(PI * t / duration_);
    }
    if (form_ == Form::harmonic) return amplitude_ * std::sin(2.0 * PI * t / duration_);
    if (t <= rows_.front().first) return rows_.front().second;
    if (t >= rows_.back().first) return rows_.back().second;
    const std::size_t k = row(t);
    return rows_[k].second + rise(k) * (t - rows_[k].first);
  }

  /* Velocity of a displacement. */
  double slope(double t) const
  {
    if (is_smooth() && (t < 0.0 || t >= duration_)) return 0.0;
    if (is_smooth()) return amplitude_ * (window(t) * wave_slope(t) + window_slope(t) * wave(t));
    if (form_ == Form::harmonic) return 2.0 * PI / duration_ * amplitude_ * std::cos(2.0 * PI * t / duration_);
    if (t < rows_.front().first || t >= rows_.back().first) return 0.0;
    return rise(row(t));
  }

 private:
  // smooth after the ramp
  enum class Form { half_sine, rectangle, harmonic, table, ramped, burst, up_and_down, sweep, noise };

  LoadShape(Form form, double amplitude, double first, double last, double duration, double ramp) :
      form_(form), amplitude_(amplitude), first_(first), last_(last), duration_(duration), ramp_(ramp)
  {
  }

  bool is_smooth() const { return form_ >= Form::ramped; }

  /* Integral of the force from 0 to t. An odd function of t, so that a timestep centered at 0 has twice the integral of its
     second half. */
  double integral(double t) const
  {
    if (t < 0.0) return -integral(-t);
    const auto rounded = [&](double angle) {    // for A sin, whose argument at t is twice this angle
      const double s = std::sin(angle);
      return 2.0 * s * s;
    };
    switch (form_) {
      case Form::half_sine:
        return amplitude_ * duration_ / PI * (t < duration_ ? rounded(0.5 * PI * t / duration_) : 2.0);
      case Form::rectangle:
        return amplitude_ * std::min(t, duration_);
      case Form::harmonic:
        return amplitude_ * duration_ / (2.0 * PI) * rounded(PI * t / duration_);
      default:
        if (t <= rows_.front().first) return 0.0;
        if (t >= rows_.back().first) return before_.back();
        const std::size_t k = row(t);
        const double since = t - rows_[k].first;
        return before_[k] + since * (rows_[k].second + 0.5 * rise(k) * since);
    }
  }

  /* Last row with a time up to t, for t within the table */
  std::size_t row(double t) const
  {
    const auto later =
        std::upper_bound(rows_.begin(), rows_.end(), t, [](double at, const auto &r) { return at < r.first; });
    return later - rows_.begin() - 1;
  }
  double rise(std::size_t k) const
  {
    return (rows_[k + 1].second - rows_[k].second) / (rows_[k + 1].first - rows_[k].first);
  }

  /* Integral of a smooth form from a >= 0 to b; by Gauss's rule with three points, which is exact to (2 pi f (b - a))^6/2e6. */
  double smooth_integral(double a, double b) const
  {
    constexpr double POINT = 0.774596669241483377, OUTER = 5.0 / 18.0, INNER = 4.0 / 9.0;
    b = std::min(b, duration_);
    if (b <= a) return 0.0;
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    return 2.0 * half * (OUTER * (value(middle - POINT * half) + value(middle + POINT * half)) + INNER * value(middle));
  }

  /* Set the waves of noise. Their phases are uniform random numbers, the same everywhere: splitmix64 (Steele, Lea and Flood 2014). */
  void set_phases(std::uint64_t seed)
  {
    const auto lowest = static_cast<long>(std::ceil(first_ * duration_ * (1.0 - 1e-12)));
    const auto highest = static_cast<long>(std::floor(last_ * duration_ * (1.0 + 1e-12)));
    if (lowest < 1 || highest < lowest) throw std::invalid_argument("no multiple of 1/T lies between its frequencies");
    for (long k = lowest; k <= highest; k++) {
      std::uint64_t z = (seed += 0x9e3779b97f4a7c15u);
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
      rates_.push_back(2.0 * PI * static_cast<double>(k) / duration_);
      phases_.push_back(2.0 * PI * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53));
    }
    amplitude_ *= std::sqrt(2.0 / static_cast<double>(rates_.size()));
  }

  double window(double t) const
  {
    if (form_ == Form::burst) return squared_sine(PI * t / duration_);
    const double since = std::min(t, duration_ - t);
    if (form_ == Form::up_and_down) return 2.0 * since / duration_;
    return since < ramp_ ? squared_sine(0.5 * PI * since / ramp_) : 1.0;
  }
  double window_slope(double t) const
  {
    if (form_ == Form::burst) return PI / duration_ * std::sin(2.0 * PI * t / duration_);
    const double since = std::min(t, duration_ - t);
    if (form_ == Form::up_and_down) return (since < t ? -2.0 : 2.0) / duration_;
    if (since >= ramp_) return 0.0;
    return (since < t ? -0.5 : 0.5) * PI / ramp_ * std::sin(PI * since / ramp_);
  }
  static double squared_sine(double angle)
  {
    const double s = std::sin(angle);
    return s * s;
  }
  double frequency_rise() const { return (last_ - first_) / duration_; }
  double phase(double t) const { return 2.0 * PI * t * (first_ + 0.5 * frequency_rise() * t); }
  double wave(double t) const
  {
    if (form_ != Form::noise) return std::sin(phase(t));
    double sum = 0.0;
    for (std::size_t k = 0; k < rates_.size(); k++) sum += std::sin(rates_[k] * t + phases_[k]);
    return sum;
  }
  double wave_slope(double t) const
  {
    if (form_ != Form::noise) return 2.0 * PI * (first_ + frequency_rise() * t) * std::cos(phase(t));
    double sum = 0.0;
    for (std::size_t k = 0; k < rates_.size(); k++) sum += rates_[k] * std::cos(rates_[k] * t + phases_[k]);
    return sum;
  }

  Form form_ = Form::harmonic;
  double amplitude_ = 0.0, first_ = 0.0, last_ = 0.0;    // frequencies at the start and the end
  double duration_ = 1.0;                                // or the period of a harmonic load without a ramp
  double ramp_ = 0.0;
  Rows rows_;
  std::vector<double> before_;            // integral up to each row
  std::vector<double> rates_, phases_;    // of noise
};

}    // namespace granwave

#endif
