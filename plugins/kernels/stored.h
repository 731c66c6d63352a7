// SPDX-License-Identifier: GPL-2.0-only
/* Objects stored in blocks of doubles, which messages and restart files copy unchanged. They are copied from their doubles
   and back, never used in place: no object lives in that memory. No LAMMPS types. */

#ifndef GRANWAVE_STORED_H
#define GRANWAVE_STORED_H

#include <cstring>
#include <type_traits>

namespace granwave {

/* Number of doubles of an object. */
template <class Object> constexpr int doubles_of()
{
  static_assert(std::is_trivially_copyable_v<Object>);
  static_assert(sizeof(Object) % sizeof(double) == 0);
  return static_cast<int>(sizeof(Object) / sizeof(double));
}

/* Return the object stored in these doubles. */
template <class Object> Object from_doubles(const double *from)
{
  static_assert(doubles_of<Object>() > 0);
  Object object;
  std::memcpy(static_cast<void *>(&object), from, sizeof(object));
  return object;
}

/* Write an object into doubles. Returns the position after them. */
template <class Object> double *to_doubles(const Object &object, double *to)
{
  std::memcpy(to, &object, sizeof(object));
  return to + doubles_of<Object>();
}

/* Object of a block: read where this is made, and written back where it ends. Only one at a time of the same object. */
template <class Object> class Stored {
 public:
  explicit Stored(double *place) : place_(place), object_(from_doubles<Object>(place)) {}
  ~Stored() { to_doubles(object_, place_); }
  Stored(const Stored &) = delete;
  Stored &operator=(const Stored &) = delete;

  Object *operator->() { return &object_; }
  Object &operator*() { return object_; }

 private:
  double *const place_;
  Object object_;
};

}    // namespace granwave

#endif
