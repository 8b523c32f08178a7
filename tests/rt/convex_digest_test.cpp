// SPDX-License-Identifier: BSD-3-Clause
// rt/convex gives the same bits with every compiler and on every processor: one number over ten thousand
// pairs.
#include <bit>
#include <catch2/catch.hpp>
#include <cinttypes>
#include <cstdio>

#include "rt/convex/manifold.hpp"
#include "tests/rt/convex_oracle.hpp"

namespace sortie::rt::convex::test {
namespace {

// FNV-1a, independent of the library's own digest.
class Fnv {
 public:
  void add(std::uint64_t x) {
    for (int shift = 0; shift < 64; shift += 8) state_ = (state_ ^ ((x >> shift) & 0xffu)) * 0x100000001b3u;
  }
  void add(double x) { add(std::bit_cast<std::uint64_t>(x)); }
  void add(const Vector3& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_{0xcbf29ce484222325u};
};

void add(Fnv& fnv, const Manifold& m) {
  fnv.add(static_cast<std::uint64_t>(m.state));
  for (std::uint32_t i = 0; i < m.count; ++i) {
    fnv.add(m.contacts[i].point_m);
    fnv.add(m.contacts[i].normal);
    fnv.add(m.contacts[i].depth_m);
    fnv.add(static_cast<std::uint64_t>(m.contacts[i].id));
  }
}

}  // namespace

TEST_CASE("convex: the same bits with every compiler and on every processor") {
  Draw draw(99);
  Fnv settled;   // what our own arithmetic decides alone
  Fnv with_ccd;  // pairs that libccd was asked about
  int asked = 0;
  for (int i = 0; i < 10000; ++i) {
    Convex a = i % 4 == 0 ? any_box(draw) : any_track(draw);
    Convex b = i % 16 == 1 ? make_swept_ellipsoid({0.35, 0.3, 0.15}, {0.4, 0.1, 0.05}) : any_box(draw);
    b.R_world_body = to_matrix(draw.turn());
    const double overlap = draw.within(-0.002, 0.004);
    put_shallow(draw, a, i % 16 == 1 ? any_box(draw) : b, overlap);
    const QueryResult q = query(a, b);
    Fnv& fnv = q.support_calls == 0 ? settled : with_ccd;
    asked += q.support_calls == 0 ? 0 : 1;
    fnv.add(static_cast<std::uint64_t>(q.state));
    fnv.add(q.depth_m);
    fnv.add(q.normal);
    fnv.add(q.point_m);
    add(fnv, manifold(a, b));
    add(settled, manifold(a, HalfSpace{{0, 0, 1}, a.p_world_m.z - 0.02}));
  }
  std::printf("convex digests %016" PRIx64 " %016" PRIx64 ", libccd asked about %d of 10000\n",
              settled.value(), with_ccd.value(), asked);
  CHECK(settled.value() == 0xbebd19e939795fd8u);
  CHECK(with_ccd.value() == 0x88c0e2e17a9b526eu);
}

}  // namespace sortie::rt::convex::test
