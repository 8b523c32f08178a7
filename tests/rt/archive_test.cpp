// SPDX-License-Identifier: BSD-3-Clause
// State to bytes and back: what is forgotten is noticed, what is damaged is refused, and nothing else
// happens.
#include "rt/archive.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"
#include "rt/stamp_gate.hpp"

using namespace sortie;
using namespace sortie::rt;

namespace {

enum class Mode : std::uint16_t { idle, busy };

struct Pose {
  Nanoseconds stamp_ns{};
  Vector3 p;
  float share{};
  Mode mode{};
  SORTIE_FIELDS(stamp_ns, p, share, mode)
};

class Filter {
 public:
  explicit Filter(double gain) : gain_(gain) {}
  void archive(Archive& archive) {
    Members(archive, *this, "filter").fixed(gain_).state(mean_, pose_, history_, on_).by_hand(size_);
    archive.bounded(size_, 5);
  }
  double gain_;
  double mean_{};
  Pose pose_;
  std::array<std::uint32_t, 5> history_{};
  std::uint32_t size_{};
  bool on_{};
};

// As Filter, with a member that nobody told the archive of.
class Forgetful {
 public:
  void archive(Archive& archive) { Members(archive, *this, "forgetful").state(a_, c_); }
  double a_{};
  std::uint32_t b_{};
  std::uint32_t spare_{};
  double c_{};
};
class ForgetfulAtItsEnd {
 public:
  void archive(Archive& archive) { Members(archive, *this, "forgetful at its end").state(a_); }
  double a_{};
  std::uint64_t b_{};
};
struct UnlistedField {
  double a{};
  double b{};
  SORTIE_FIELDS(a)
};
class WithBase : public Filter {
 public:
  WithBase() : Filter(1) {}
  virtual ~WithBase() = default;
  void archive(Archive& archive) {
    Filter::archive(archive);
    Members(archive, *this, "with base").base<Filter>().state(more_);
  }
  std::uint64_t more_{};
};

template <class T>
std::vector<std::uint8_t> bytes_of(T& value) {
  Archive measure = Archive::measuring();
  measure.value(value);
  INFO(measure.where() << ": " << measure.why());
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  Archive write = Archive::writing(bytes);
  write.value(value);
  REQUIRE(write.status() == Status::ok);
  REQUIRE(write.bytes() == bytes.size());
  return bytes;
}

template <class T>
Archive measured(T& value) {
  Archive measure = Archive::measuring();
  measure.value(value);
  return measure;
}

}  // namespace

TEST_CASE("what an archive wrote it reads back, in the canonical form") {
  Filter filter(0.5);
  filter.mean_ = -0.0;
  filter.pose_ = {-7, {1.5, -2, std::numeric_limits<double>::denorm_min()}, 0.25f, Mode::busy};
  filter.history_ = {1, 2, 3, 4, 0xffffffffu};
  filter.size_ = 3;
  filter.on_ = true;
  const auto bytes = bytes_of(filter);
  // 8 mean, 8 + 24 + 4 + 2 pose, 20 history, 1 flag, 4 size: no padding, no configuration.
  CHECK(bytes.size() == 71);
  CHECK(bytes[7] == 0x80);  // -0.0, little endian
  CHECK(bytes[8] == 0xf9);  // -7
  CHECK(bytes[44] == 1);    // Mode::busy
  CHECK(bytes[46] == 1);    // history

  Filter again(0.5);
  Archive read = Archive::reading(bytes);
  read.value(again);
  CHECK(read.status() == Status::ok);
  CHECK(read.bytes() == bytes.size());
  CHECK(bytes_of(again) == bytes);
  CHECK(again.pose_.p.z == std::numeric_limits<double>::denorm_min());
  CHECK(again.on_);
}

TEST_CASE("every NaN is written as the same NaN") {
  double first = std::numeric_limits<double>::quiet_NaN();
  double second = std::bit_cast<double>(std::uint64_t{0xfff8dead00000001u});
  CHECK(bytes_of(first) == bytes_of(second));
}

TEST_CASE("a forgotten member is noticed and its class named") {
  Filter filter(1);
  WithBase with_base;
  StampGate gate(5);
  CHECK(measured(filter).status() == Status::ok);
  CHECK(measured(with_base).status() == Status::ok);
  CHECK(measured(gate).status() == Status::ok);
  Forgetful middle;
  ForgetfulAtItsEnd end;
  UnlistedField unlisted;
  CHECK(measured(middle).status() == Status::not_supported);
  CHECK(std::string(measured(middle).where()) == "forgetful");
  CHECK(std::string(measured(middle).why()).find("archive()") != std::string::npos);
  CHECK(measured(end).status() == Status::not_supported);
  CHECK(measured(unlisted).status() == Status::not_supported);

  Archive archive = Archive::measuring();
  { Members(archive, gate, "gate").state(filter.mean_); }
  CHECK(archive.status() == Status::not_supported);
  CHECK(std::string(archive.why()).find("another object") != std::string::npos);
}

TEST_CASE("whatever the bytes hold reading stays inside them and inside the memory") {
  Filter filter(1);
  filter.size_ = 5;
  const auto good = bytes_of(filter);
  for (std::size_t size = 0; size < good.size(); ++size) {
    // A copy of its own, so that a sanitizer sees every byte too many.
    const std::vector<std::uint8_t> cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    Archive read = Archive::reading(cut);
    Filter again(1);
    read.value(again);
    CHECK(read.status() == Status::malformed);
    CHECK(again.size_ <= 5);
  }
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 20000; ++round) {
    auto bad = good;
    for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    Archive read = Archive::reading(bad);
    Filter again(1);
    read.value(again);
    CHECK(again.size_ <= 5);
  }
  auto no_truth = good;
  no_truth[66] = 2;
  Archive read = Archive::reading(no_truth);
  read.value(filter);
  CHECK(read.status() == Status::malformed);
  CHECK(std::string(read.where()) == "filter");
}

TEST_CASE("too little room is said and nothing is written behind it") {
  Filter filter(1);
  const auto good = bytes_of(filter);
  std::vector<std::uint8_t> out(good.size(), 0xee);
  Archive write = Archive::writing(std::span(out).first(20));
  write.value(filter);
  CHECK(write.status() == Status::full);
  CHECK(write.bytes() <= 20);
  for (std::size_t i = 20; i < out.size(); ++i) CHECK(out[i] == 0xee);
}

TEST_CASE("a number that must be the same is compared") {
  std::uint8_t bytes[8];
  Archive write = Archive::writing(bytes);
  write.expect(64, "capacity");
  Archive same = Archive::reading(bytes);
  same.expect(64, "capacity");
  CHECK(same.status() == Status::ok);
  Archive other = Archive::reading(bytes);
  other.expect(128, "capacity");
  CHECK(other.status() == Status::malformed);
  CHECK(std::string(other.why()) == "capacity");
}
