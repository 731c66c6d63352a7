// SPDX-License-Identifier: GPL-2.0-only
/* Load as a function of time, in closed form. No LAMMPS types.

     half-sine    A sin(pi t/T)      0 <= t <= T, else 0
     rectangle    A                  0 <= t <= T, else 0
     harmonic     A sin(2 pi f t)    from t = 0 on
     table        linear interpolation  */

#ifndef GRANWAVE_LOAD_SHAPE_H
#define GRANWAVE_LOAD_SHAPE_H

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace granwave {

class LoadShape {
 public:
  enum class Form { half_sine, rectangle, harmonic, table };
  using Rows = std::vector<std::pair<double, double>>;    // time, value

  LoadShape() = default;

  /* `period` is the duration T of a pulse, or 1/f. */
  LoadShape(Form form, double amplitude, double period) : form_(form), amplitude_(amplitude), period_(period) {}

  /* At least two rows with increasing times are required; throws std::invalid_argument otherwise. */
  explicit LoadShape(Rows rows) : form_(Form::table), rows_(std::move(rows))
  {
    if (rows_.size() < 2) throw std::invalid_argument("it needs at least two rows, found " + std::to_string(rows_.size()));
    if (rows_[0].first < 0.0) throw std::invalid_argument("its first time is negative");
    before_.push_back(0.0);
    for (std::size_t k = 1; k < rows_.size(); k++) {
      const auto &[t, value] = rows_[k];
      const auto &[earlier, last] = rows_[k - 1];
      if (!(t > earlier)) throw std::invalid_argument("its times must rise, and row " + std::to_string(k + 1) + " does not");
      before_.push_back(before_.back() + 0.5 * (value + last) * (t - earlier));
    }
  }

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
        return amplitude_ * period_ / PI_ * (t < period_ ? rounded(0.5 * PI_ * t / period_) : 2.0);
      case Form::rectangle:
        return amplitude_ * std::min(t, period_);
      case Form::harmonic:
        return amplitude_ * period_ / (2.0 * PI_) * rounded(PI_ * t / period_);
      default:
        if (t <= rows_.front().first) return 0.0;
        if (t >= rows_.back().first) return before_.back();
        const std::size_t k = row(t);
        const double since = t - rows_[k].first;
        return before_[k] + since * (rows_[k].second + 0.5 * rise(k) * since);
    }
  }

  /* Displacement and its velocity: harmonic, or a table, constant before its first and after its last row. */
  double value(double t) const
  {
    if (form_ == Form::harmonic) return amplitude_ * std::sin(2.0 * PI_ * t / period_);
    if (t <= rows_.front().first) return rows_.front().second;
    if (t >= rows_.back().first) return rows_.back().second;
    const std::size_t k = row(t);
    return rows_[k].second + rise(k) * (t - rows_[k].first);
  }

  double slope(double t) const
  {
    if (form_ == Form::harmonic) return 2.0 * PI_ / period_ * amplitude_ * std::cos(2.0 * PI_ * t / period_);
    if (t < rows_.front().first || t >= rows_.back().first) return 0.0;
    return rise(row(t));
  }

 private:
  static constexpr double PI_ = 3.14159265358979323846;

  /* Last row whose time is not after t, for t within the table */
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

  Form form_ = Form::harmonic;
  double amplitude_ = 0.0, period_ = 1.0;
  Rows rows_;
  std::vector<double> before_;    // integral up to each row
};

}    // namespace granwave

#endif
