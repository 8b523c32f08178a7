// SPDX-License-Identifier: BSD-3-Clause
// The ground under the campaign: transcendentals and rotations, queues beside twins, stamps, counters.
#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>

#include "rt/histogram.hpp"
#include "rt/math.hpp"
#include "rt/overwrite_ring.hpp"
#include "rt/rotation.hpp"
#include "rt/saturating_count.hpp"
#include "rt/spsc_ring.hpp"
#include "rt/stamp_gate.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"

namespace sortie::bench {

namespace {

constexpr double kHalfTurn = 3.14159265358979323846;

bool within_one(double x) { return x >= -1.0 && x <= 1.0; }

// Results for finite arguments, each within its range; for the others no number, and never a trap.
void try_functions(CampaignTrial& trial, const CampaignOp& op) {
  // Spread over all exponents, as well as near 1.
  const double x = op.kind % 2 == 0 ? op.value[0] : op.value[0] * rt::exp(op.value[1] * 300.0);
  const double y = op.value[2];
  trial.count(std::isfinite(x) && std::isfinite(y));
  if (!std::isfinite(x) || !std::isfinite(y)) {
    trial.need(std::isfinite(x) || std::isnan(rt::sin(x)), "the sine of what is not finite is a number");
    return;
  }
  const rt::SinCos both = rt::sincos(x);
  trial.need(within_one(both.sin) && within_one(both.cos), "a sine or cosine lies beyond 1");
  trial.need(std::fabs(both.sin * both.sin + both.cos * both.cos - 1.0) < 1e-15,
             "sine and cosine are no pair");
  trial.see(rt::atan2(y, x), "atan2 is not finite");
  trial.need(std::fabs(rt::atan2(y, x)) <= kHalfTurn, "atan2 lies beyond half a turn");
  trial.need(std::fabs(rt::atan(x)) <= 0.5 * kHalfTurn, "atan lies beyond a quarter of a turn");
  const double power = rt::exp(x);
  trial.need(power >= 0.0, "exp is below zero or no number");
  const double length = rt::hypot(x, y);
  trial.need(length >= std::fabs(x) && length >= std::fabs(y), "hypot is shorter than a side");
  trial.fold(std::bit_cast<std::uint64_t>(length));
  if (x > 0.0) {
    const double exponent = rt::log(x);
    trial.see(exponent, "the logarithm is not finite");
    if (std::fabs(exponent) < 600.0) {
      const double size = 1.0 + std::fabs(exponent);
      trial.need(std::fabs(rt::exp(exponent) / x - 1.0) < 1e-15 * size, "exp does not undo log");
    }
  }
  if (within_one(x)) trial.need(std::fabs(rt::sin(rt::asin(x)) - x) < 1e-15, "sin does not undo asin");
  const double wrapped = rt::wrap_angle(x);
  // What is promised, and what is left of an angle beyond 1e9 rad is its own rounding.
  trial.need(!(std::fabs(x) < 1e9) || std::fabs(wrapped) <= kHalfTurn + 1e-7,
             "a wrapped angle lies beyond half a turn");
}

void try_rotations(CampaignTrial& trial, const CampaignOp& op) {
  const auto& v = op.value;
  const rt::Vector3 phi{kHalfTurn * v[0], kHalfTurn * v[1], kHalfTurn * v[2]};
  const double size = rt::norm(phi);
  const bool usable = size < 1e6;
  trial.count(usable);
  if (!usable) return;
  const rt::Quaternion q = rt::exp_rotation(phi);
  trial.need(std::fabs(rt::squared_norm(q) - 1.0) < 1e-14, "a rotation's quaternion is not of length 1");
  const rt::Vector3 back = rt::log_rotation(q);
  trial.need(rt::norm(back) <= kHalfTurn * (1.0 + 1e-15), "a rotation vector is longer than half a turn");
  const rt::Quaternion again = rt::exp_rotation(back);
  trial.need(rt::norm(rt::log_rotation(rt::conjugate(q) * again)) < 1e-14,
             "exp does not undo log of a rotation");
  const rt::Quaternion matrix = rt::from_matrix(rt::to_matrix(q));
  trial.need(rt::norm(rt::log_rotation(rt::conjugate(q) * matrix)) < 1e-14, "the matrix is another rotation");
  const rt::Quaternion angles = rt::from_yaw_pitch_roll(rt::yaw_of(q), rt::pitch_of(q), rt::roll_of(q));
  // Within 1e-8 rad of the gimbal lock roll and yaw say little by themselves, but their turn is whole.
  trial.need(rt::norm(rt::log_rotation(rt::conjugate(q) * angles)) < 1e-7, "the angles are another rotation");
  const double t = std::fabs(v[3]) <= 1.0 ? std::fabs(v[3]) : 0.5;
  trial.need(std::fabs(rt::squared_norm(rt::slerp(q, {1, 0, 0, 0}, t)) - 1.0) < 1e-14,
             "slerp leaves length 1");
  trial.see(q.w, "a quaternion is not finite");
  trial.see(back.x, "a rotation vector is not finite");
  const rt::Vector3 from{v[4], v[5], v[6]};
  const double length = rt::norm(from);
  // The squares of both lengths are multiplied: beyond 1e77 that is beyond all numbers.
  if (!(length > 1e-70 && length < 1e70)) return;
  const rt::Vector3 to = rt::rotate(q, from);
  const rt::Vector3 there = rt::rotate(rt::rotation_between(from, to), from);
  // Near opposite directions 1 + cosine has few digits left, and beyond 1e-12 any half turn will do.
  const double open = 1.0 + rt::dot(from, to) / (length * length);
  const double bound = open > 1e-11 ? 1e-13 + 1e-15 / open : 1e-5;
  trial.need(rt::norm(there - to) < bound * length, "the shortest rotation does not lead there");
}

}  // namespace

CampaignOutcome run_math_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  for (const CampaignOp& op : ops) {
    trial.real_time([&] {
      if (op.kind % 4 < 2) {
        try_functions(trial, op);
      } else {
        try_rotations(trial, op);
      }
      return 0;
    });
  }
  return trial.end();
}

CampaignOutcome run_queue_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  const std::uint32_t first =
      ops.empty() ? 0 : 0u - whole_of(ops[0].value[6], 40);  // wraps within the sequence
  rt::SpscRing<std::uint32_t, 16> ring(first);
  rt::OverwriteRing<std::uint32_t, 8> newest(first);
  rt::OverwriteRing<std::uint32_t, 8>::Reader reader(newest);
  std::deque<std::uint32_t> twin;
  std::deque<std::uint32_t> kept;
  std::uint64_t twin_lost = 0;
  std::uint32_t next = 0;
  for (const CampaignOp& op : ops) {
    const std::uint32_t wanted = whole_of(op.value[0], 24);
    std::uint32_t buffer[24]{};
    switch (op.kind % 6) {
      case 0: {
        const bool taken = trial.real_time([&] { return ring.try_push(next); });
        trial.need(taken == (twin.size() < 16), "a full ring took an element, or one with room refused it");
        if (taken) twin.push_back(next);
        trial.count(taken);
        ++next;
        break;
      }
      case 1: {
        std::uint32_t got = 77;
        const bool taken = trial.real_time([&] { return ring.try_pop(got); });
        trial.need(taken == !twin.empty(), "an empty ring gave an element, or one that was not gave none");
        if (taken) {
          trial.need(got == twin.front(), "another element came out than went in");
          twin.pop_front();
        }
        trial.fold(got);
        break;
      }
      case 2: {
        for (std::uint32_t i = 0; i < wanted; ++i) buffer[i] = next + i;
        const std::uint32_t put = trial.real_time([&] { return ring.push_n(buffer, wanted); });
        trial.need(put == std::min<std::size_t>(wanted, 16 - twin.size()),
                   "push_n took another number than fits");
        for (std::uint32_t i = 0; i < put; ++i) twin.push_back(next + i);
        trial.count_many(wanted, put, wanted - put);
        next += wanted;
        break;
      }
      case 3: {
        const std::uint32_t got = trial.real_time([&] { return ring.pop_n(buffer, wanted); });
        trial.need(got == std::min<std::size_t>(wanted, twin.size()),
                   "pop_n gave another number than there is");
        for (std::uint32_t i = 0; i < got && !twin.empty(); ++i) {
          trial.need(buffer[i] == twin.front(), "another element came out than went in");
          twin.pop_front();
        }
        break;
      }
      case 4:
        trial.real_time([&] {
          newest.push(next);
          return 0;
        });
        kept.push_back(next++);
        if (kept.size() > 7) {
          kept.pop_front();
          ++twin_lost;
        }
        trial.count(true);
        break;
      default: {
        std::uint32_t got = 77;
        std::uint32_t lost = 0;
        const Status status = trial.real_time([&] { return reader.read(got, lost); });
        trial.need((status == Status::ok) == !kept.empty(), "the newest elements are not there");
        if (status == Status::ok && !kept.empty()) {
          trial.need(got == kept.front(), "not the oldest of the newest elements");
          kept.pop_front();
        }
        if (status == Status::ok) trial.need(reader.lost() == twin_lost, "lost elements are miscounted");
      }
    }
    trial.need(ring.size() == twin.size(), "the ring's size is another");
    trial.fold(ring.size());
  }
  return trial.end();
}

CampaignOutcome run_stamp_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  constexpr rt::Nanoseconds kLongest = 10 * rt::kNanosecondsPerSecond;
  rt::StampGate gate(kLongest);
  rt::SaturatingCount count;
  rt::LatencyHistogram histogram;
  CampaignClock clock;
  std::uint64_t taken = 0;
  std::uint64_t doubted = 0;
  for (const CampaignOp& op : ops) {
    const rt::Nanoseconds stamp = clock.step(op);
    const bool before = gate.started();
    const rt::Nanoseconds last = gate.last();
    const Status status = trial.answered(trial.real_time([&] { return gate.take(stamp); }));
    if (status == Status::ok) {
      trial.need(gate.last() == stamp, "the newest stamp is not the one that was taken");
      trial.need(!before || gate.resumed() || (stamp > last && stamp - last <= kLongest),
                 "a stamp back or too far ahead was taken");
      trial.need(!gate.resumed() || doubted >= 7, "a new time line began too early");
      doubted = 0;
      ++taken;
      trial.real_time([&] {
        histogram.record(static_cast<std::uint64_t>(before && !gate.resumed() ? stamp - last : 0));
        count.add();
        return 0;
      });
    } else {
      trial.need(gate.last() == last, "a refused stamp moved the newest");
      ++doubted;
    }
    trial.fold(static_cast<std::uint64_t>(gate.last()));
    if (op.kind % 3 == 1) {
      const std::uint64_t to = op.value[0] < 0.0 ? rt::SaturatingCount::kTop - 1 : whole_of(op.value[0], 100);
      count.set(to + taken);
      trial.need(count.value() == std::min<std::uint64_t>(to + taken, rt::SaturatingCount::kTop),
                 "a count wrapped");
    }
    if (op.kind % 3 == 2) {
      const std::uint64_t share = trial.real_time([&] { return histogram.percentile(op.value[1]); });
      trial.need(share >= histogram.min() || op.value[1] <= 0.0 || taken == 0,
                 "a percentile lies below the least");
      trial.need(share <= histogram.max(), "a percentile lies above the largest");
    }
  }
  trial.need(histogram.count() == taken, "the histogram has another count");
  return trial.end();
}

}  // namespace sortie::bench
