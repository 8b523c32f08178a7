// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/portal.hpp"

#include <ccd/ccd.h>

static_assert(sizeof(ccd_real_t) == sizeof(double), "libccd was built for single precision");

namespace sortie::rt::convex {
namespace {

constexpr double kTolerance_m = 1e-4;
constexpr unsigned long kRounds = 32;  // of the one loop that libccd bounds itself

struct Counter {
  std::uint32_t left{};
  std::uint32_t calls{};
  bool exhausted{};
  Vector3 last_direction{};
};

struct Side {
  const SupportBody* body{};
  Counter* counter{};
  bool leads{};  // libccd asks this one first, with the direction itself
  mutable Vector3 last{};
};

Vector3 to_vector3(const ccd_vec3_t& v) { return {v.v[0], v.v[1], v.v[2]}; }
void put(const Vector3& v, ccd_vec3_t* out) { ccdVec3Set(out, v.x, v.y, v.z); }

void counted_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const Side& side = *static_cast<const Side*>(object);
  Counter& counter = *side.counter;
  if (counter.left == 0) {
    counter.exhausted = true;
  } else {
    --counter.left;
    ++counter.calls;
    const Vector3 d = to_vector3(*direction);
    if (side.leads) counter.last_direction = d;
    side.last = side.body->support(side.body->body, d);
  }
  put(side.last, point);
}

void inside_point(const void* object, ccd_vec3_t* point) {
  put(static_cast<const Side*>(object)->body->inside, point);
}

}  // namespace

PortalResult refine_portal(const SupportBody& a, const SupportBody& b, std::uint32_t budget) {
  Counter counter;
  counter.left = budget;
  // libccd moves its second body along the direction; so b comes first here.
  const Side first{&b, &counter, true, b.inside};
  const Side second{&a, &counter, false, a.inside};
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = counted_support;
  ccd.support2 = counted_support;
  ccd.center1 = inside_point;
  ccd.center2 = inside_point;
  ccd.max_iterations = kRounds;
  ccd.mpr_tolerance = kTolerance_m;
  ccd_real_t depth = 0.0;
  ccd_vec3_t direction;
  ccd_vec3_t position;
  put({}, &direction);
  put({}, &position);
  const int said = ccdMPRPenetration(&first, &second, &ccd, &depth, &direction, &position);
  PortalResult result;
  result.state =
      counter.exhausted ? PortalState::exhausted : (said == 0 ? PortalState::meeting : PortalState::apart);
  result.last_direction = counter.last_direction;
  result.depth_direction = to_vector3(direction);
  result.support_calls = counter.calls;
  return result;
}

}  // namespace sortie::rt::convex
