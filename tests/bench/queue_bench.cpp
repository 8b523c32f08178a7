// SPDX-License-Identifier: BSD-3-Clause
// What of the queues `sortie bench rt` does not measure (single calls, threads, round trips and mailboxes are
// there): batches in place or through copies, the ring that overwrites, the newest value for several readers;
// and rigtorp's queue where its header is installed. One thread: the cost of an uncontended operation.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>

#include "rt/mailbox.hpp"
#include "rt/overwrite_ring.hpp"
#include "rt/samples.hpp"
#include "rt/spsc_ring.hpp"
#include "tests/bench/ratio_table.hpp"
#ifdef SORTIE_PEER_BOOST
#include <boost/lockfree/spsc_queue.hpp>
#endif
#if __has_include(<rigtorp/SPSCQueue.h>)
#include <rigtorp/SPSCQueue.h>
#define SORTIE_PEER_RIGTORP 1
#endif

namespace {

using sortie::rt::ImuSample;
using sortie::rt::PoseEstimate;

constexpr std::uint32_t kBatch = 16;
constexpr std::uint32_t kSlots = 1024;
static_assert(sizeof(ImuSample) == 64);

using SortieRing = sortie::rt::SpscRing<ImuSample, kSlots>;

// A batch as it is used: made, moved, summed up. In place, or through arrays that are copied.
void make(ImuSample& sample, std::int64_t stamp_ns) {
  sample.stamp_ns = stamp_ns;
  for (double& rate : sample.gyr_rad_s) rate = 0.5;
  for (double& force : sample.acc_m_s2) force = 9.81;
  sample.flags = sortie::rt::kImuGyr | sortie::rt::kImuAcc;
}

double used(const ImuSample& sample) { return sample.gyr_rad_s[2] + sample.acc_m_s2[2]; }

std::size_t put(SortieRing& ring, const ImuSample* samples) { return ring.push_n(samples, kBatch); }
std::size_t get(SortieRing& ring, ImuSample* samples) { return ring.pop_n(samples, kBatch); }

#ifdef SORTIE_PEER_BOOST
using BoostRing = boost::lockfree::spsc_queue<ImuSample, boost::lockfree::capacity<kSlots>>;
std::size_t put(BoostRing& ring, const ImuSample* samples) { return ring.push(samples, kBatch); }
std::size_t get(BoostRing& ring, ImuSample* samples) { return ring.pop(samples, kBatch); }
#else
[[maybe_unused]] const int kNoBoost =
    sortie::bench::skip_peer("boost::lockfree::spsc_queue", "not installed; apt-get install libboost-dev");
#endif

template <class Queue>
void batch_used(benchmark::State& state) {
  auto queue = std::make_unique<Queue>();
  alignas(64) ImuSample in[kBatch]{};
  alignas(64) ImuSample out[kBatch]{};
  std::int64_t stamp_ns = 0;
  double sum = 0;
  for (auto _ : state) {
    for (ImuSample& sample : in) make(sample, ++stamp_ns);
    benchmark::DoNotOptimize(put(*queue, in));
    const auto count = get(*queue, out);
    for (std::size_t i = 0; i < count; ++i) sum += used(out[i]);
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ops"] = kBatch;
}

void batch_in_place(benchmark::State& state) {
  auto ring = std::make_unique<SortieRing>();
  std::int64_t stamp_ns = 0;
  double sum = 0;
  for (auto _ : state) {
    const auto room = ring->claim(kBatch);
    for (ImuSample& sample : room) make(sample, ++stamp_ns);
    ring->publish(kBatch);
    const auto there = ring->peek(kBatch);
    for (const ImuSample& sample : there) sum += used(sample);
    ring->release(kBatch);
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ops"] = kBatch;
}
BENCHMARK(batch_in_place)->Name("ring_made_and_used_16/sortie");
BENCHMARK(batch_used<SortieRing>)->Name("ring_made_and_used_16/sortie, by copies");
#ifdef SORTIE_PEER_BOOST
BENCHMARK(batch_used<BoostRing>)->Name("ring_made_and_used_16/boost::lockfree::spsc_queue");
#endif

#ifdef SORTIE_PEER_RIGTORP
void single_sortie(benchmark::State& state) {
  auto ring = std::make_unique<SortieRing>();
  ImuSample in{};
  ImuSample out{};
  for (auto _ : state) {
    benchmark::DoNotOptimize(in);
    benchmark::DoNotOptimize(ring->try_push(in));
    benchmark::DoNotOptimize(ring->try_pop(out));
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(single_sortie)->Name("ring_single/sortie");

void single_rigtorp(benchmark::State& state) {
  rigtorp::SPSCQueue<ImuSample> ring(kSlots);
  ImuSample in{};
  ImuSample out{};
  for (auto _ : state) {
    benchmark::DoNotOptimize(in);
    benchmark::DoNotOptimize(ring.try_push(in));
    if (const ImuSample* const front = ring.front(); front != nullptr) {
      out = *front;
      ring.pop();
    }
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(single_rigtorp)->Name("ring_single/rigtorp::SPSCQueue");
#else
[[maybe_unused]] const int kNoRigtorp =
    sortie::bench::skip_peer("rigtorp::SPSCQueue", "rigtorp/SPSCQueue.h is not on the include path");
#endif

void overwriting_sortie(benchmark::State& state) {
  using Ring = sortie::rt::OverwriteRing<ImuSample, kSlots>;
  auto ring = std::make_unique<Ring>();
  Ring::Reader reader(*ring);
  ImuSample sample{};
  std::uint32_t lost = 0;
  for (auto _ : state) {
    sample.stamp_ns += 1;
    ring->push(sample);
    benchmark::DoNotOptimize(reader.read(sample, lost));
    benchmark::DoNotOptimize(sample);
  }
}
BENCHMARK(overwriting_sortie)->Name("ring_overwriting/sortie");

void overwriting_deque(benchmark::State& state) {
  std::mutex mutex;
  std::deque<ImuSample> queue;
  ImuSample sample{};
  for (auto _ : state) {
    sample.stamp_ns += 1;
    {
      const std::lock_guard lock(mutex);
      if (queue.size() == kSlots) queue.pop_front();
      queue.push_back(sample);
    }
    {
      const std::lock_guard lock(mutex);
      sample = queue.front();
      queue.pop_front();
    }
    benchmark::DoNotOptimize(sample);
  }
}
BENCHMARK(overwriting_deque)->Name("ring_overwriting/std::mutex + std::deque");

void mailbox_sortie(benchmark::State& state) {
  sortie::rt::Mailbox<PoseEstimate> mailbox;
  PoseEstimate pose{};
  for (auto _ : state) {
    pose.stamp_ns += 1;
    mailbox.write(pose);
    benchmark::DoNotOptimize(mailbox.read(pose));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(mailbox_sortie)->Name("latest_pose/sortie");

}  // namespace
