// SPDX-License-Identifier: BSD-3-Clause
// Ring and mailbox in every interleaving of two small threads, under the memory model of C++. Faulty variants
// must be caught, or the model would prove nothing.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "rt/mailbox.hpp"
#include "rt/spsc_ring.hpp"
#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {
namespace {

// A size that is a power of two: the ring then counts in bytes.
struct alignas(32) WideElement : Tracked {
  using Tracked::Tracked;
};
static_assert(detail::SpscProtocol<WideElement, Modelled>::kStep == 32 &&
              detail::SpscProtocol<Tracked, Modelled>::kStep == 1);

// A ring whose producer believes in one slot more than there is: the full test is off by one.
template <class T, std::uint32_t N, template <class> class Atomic>
class OneTooMany {
 public:
  explicit OneTooMany(std::uint32_t first_index) : write_(first_index), read_(first_index) {}

  bool try_push(const T& value) {
    const std::uint32_t write = write_.load(std::memory_order_relaxed);
    if (write - read_.load(std::memory_order_acquire) > N) return false;
    slots_[write & (N - 1)] = value;
    write_.store(write + 1, std::memory_order_release);
    return true;
  }
  bool try_pop(T& value) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    if (read == write_.load(std::memory_order_acquire)) return false;
    value = slots_[read & (N - 1)];
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

 private:
  Atomic<std::uint32_t> write_;
  Atomic<std::uint32_t> read_;
  T slots_[N];
};

// The producer offers 1, 2, 3, ... in `pushes` attempts; the consumer makes `pops` attempts. Taken values
// must be 1, 2, 3, ... without a gap, and what is left at the end must follow on.
template <class Ring, class Element = Tracked>
Result single_steps(int pushes, int pops, std::uint32_t first_index, bool stop_at_failure) {
  std::unique_ptr<Ring> ring;
  int pushed = 0;
  std::vector<int> taken;
  Explorer& explorer = Explorer::instance();
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>(first_index);
        pushed = 0;
        taken.clear();
      },
      [&] {
        for (int i = 0; i < pushes; ++i) {
          const Element next(pushed + 1);
          if (ring->try_push(next)) ++pushed;
        }
      },
      [&] {
        for (int i = 0; i < pops; ++i) {
          Element value(-1);
          if (ring->try_pop(value)) taken.push_back(value.read());
        }
      },
      [&] {
        Element value(-1);
        while (ring->try_pop(value)) taken.push_back(value.read());
        if (taken.size() != static_cast<std::size_t>(pushed)) explorer.fail();
        for (std::size_t i = 0; i < taken.size(); ++i) {
          if (taken[i] != static_cast<int>(i) + 1) explorer.fail();
        }
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

// The same with batches of two.
template <class Ring>
Result batches(int pushes, int pops, std::uint32_t first_index, bool stop_at_failure) {
  std::unique_ptr<Ring> ring;
  std::uint32_t pushed = 0;
  std::vector<int> taken;
  Explorer& explorer = Explorer::instance();
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>(first_index);
        pushed = 0;
        taken.clear();
      },
      [&] {
        for (int i = 0; i < pushes; ++i) {
          const int next = static_cast<int>(pushed) + 1;
          const Tracked pair[2] = {next, next + 1};
          pushed += ring->push_n(pair, 2);
        }
      },
      [&] {
        for (int i = 0; i < pops; ++i) {
          Tracked pair[2];
          const std::uint32_t got = ring->pop_n(pair, 2);
          if (got > 2) explorer.fail();
          for (std::uint32_t k = 0; k < got; ++k) taken.push_back(pair[k].read());
          if (ring->size() > ring->capacity()) explorer.fail();
        }
      },
      [&] {
        Tracked value(-1);
        while (ring->try_pop(value)) taken.push_back(value.read());
        if (taken.size() != pushed) explorer.fail();
        for (std::size_t i = 0; i < taken.size(); ++i) {
          if (taken[i] != static_cast<int>(i) + 1) explorer.fail();
        }
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

// The same in place, two at most.
template <class Ring>
Result in_place(int pushes, int pops, std::uint32_t first_index, bool stop_at_failure) {
  std::unique_ptr<Ring> ring;
  int pushed = 0;
  int taken = 0;
  Explorer& explorer = Explorer::instance();
  const auto take = [&] {
    const auto oldest = ring->peek(2);
    for (const WideElement& value : oldest) {
      if (value.read() != ++taken) explorer.fail();
    }
    ring->release(static_cast<std::uint32_t>(oldest.size()));
    return !oldest.empty();
  };
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>(first_index);
        pushed = 0;
        taken = 0;
      },
      [&] {
        for (int i = 0; i < pushes; ++i) {
          const auto free = ring->claim(2);
          for (WideElement& slot : free) slot.write(++pushed);
          ring->publish(static_cast<std::uint32_t>(free.size()));
        }
      },
      [&] {
        for (int i = 0; i < pops; ++i) take();
      },
      [&] {
        while (take()) {
        }
        if (taken != pushed) explorer.fail();
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

// A third thread asks for the size, once, while the others push and pop. It is no more than fits, no more
// than was pushed, and brings what the producer wrote before it pushed the last of them.
Result bystander(int pushes, int pops, bool stop_at_failure) {
  using Ring = SpscRing<Tracked, 4, Modelled>;
  std::unique_ptr<Ring> ring;
  std::vector<Tracked> written;
  Explorer& explorer = Explorer::instance();
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>();
        written = std::vector<Tracked>(static_cast<std::size_t>(pushes));
      },
      {[&] {
         for (int i = 0; i < pushes; ++i) {
           written[static_cast<std::size_t>(i)].write(i + 1);
           static_cast<void>(ring->try_push(Tracked(i + 1)));
         }
       },
       [&] {
         Tracked value;
         for (int i = 0; i < pops; ++i) static_cast<void>(ring->try_pop(value));
       },
       [&] {
         const std::uint32_t size = ring->size();
         if (size > static_cast<std::uint32_t>(pushes)) explorer.fail();
         for (std::uint32_t i = 0; i < size && i < written.size(); ++i) {
           if (written[i].read() != static_cast<int>(i) + 1) explorer.fail();
         }
       }},
      [] {}, stop_at_failure);
  return {executions, explorer.failures()};
}

// The writer writes 1..writes; the reader reads `reads` times. Values never run backwards, "fresh" means
// newer, and after the end the last value is there.
template <class Box>
Result latest_value(int writes, int reads, bool stop_at_failure) {
  std::unique_ptr<Box> box;
  int last = 0;
  Explorer& explorer = Explorer::instance();
  const auto look = [&] {
    Tracked value(-1);
    const bool fresh = box->read(value);
    const int got = value.read();
    if (fresh ? got <= last : got != last) explorer.fail();
    last = got;
  };
  const std::uint64_t executions = explorer.explore(
      [&] {
        box = std::make_unique<Box>();
        last = 0;
      },
      [&] {
        for (int i = 1; i <= writes; ++i) box->write(Tracked(i));
      },
      [&] {
        for (int i = 0; i < reads; ++i) look();
      },
      [&] {
        look();
        if (last != writes) explorer.fail();
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

constexpr std::uint32_t kNearWrap = 0xffffffffu;

}  // namespace

TEST_CASE("the ring keeps order and has no race in any interleaving of four pushes and four pops",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  for (const std::uint32_t first_index : {0u, kNearWrap}) {
    const Result one = single_steps<SpscRing<Tracked, 1, Modelled>>(4, 4, first_index, false);
    const Result two = single_steps<SpscRing<Tracked, 2, Modelled>>(4, 4, first_index, false);
    const Result four =
        single_steps<SpscRing<WideElement, 4, Modelled>, WideElement>(4, 4, first_index, false);
    INFO(one.executions << ", " << two.executions << ", " << four.executions << " executions");
    CHECK(one.executions > 1000);
    CHECK(two.executions > 1000);
    CHECK(four.executions > 1000);
    CHECK(one.failures == 0);
    CHECK(two.failures == 0);
    CHECK(four.failures == 0);
  }
}

TEST_CASE("batches of the ring keep order and have no race in any interleaving", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  for (const std::uint32_t first_index : {0u, kNearWrap}) {
    const Result two = batches<SpscRing<Tracked, 2, Modelled>>(3, 3, first_index, false);
    const Result four = batches<SpscRing<Tracked, 4, Modelled>>(3, 3, first_index, false);
    INFO(two.executions << ", " << four.executions << " executions");
    CHECK(two.executions > 100);
    CHECK(two.failures == 0);
    CHECK(four.failures == 0);
  }
}

TEST_CASE("elements made and used in place keep order and have no race in any interleaving", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result two = in_place<SpscRing<WideElement, 2, Modelled>>(3, 2, kNearWrap, false);
  const Result four = in_place<SpscRing<WideElement, 4, Modelled>>(3, 2, 0, false);
  INFO(two.executions << ", " << four.executions << " executions");
  CHECK(two.executions > 100);
  CHECK(two.failures == 0);
  CHECK(four.failures == 0);
}

TEST_CASE("each memory order of the ring is needed, and its loss is caught", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order([](bool stop) {
    return single_steps<SpscRing<Tracked, 2, Modelled>>(3, 3, 0, stop) +
           batches<SpscRing<Tracked, 2, Modelled>>(2, 2, 0, stop) +
           in_place<SpscRing<WideElement, 2, Modelled>>(2, 2, 0, stop) + bystander(2, 1, stop);
  });
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"pop_n: store release", "publish: store release", "push_n: store release",
                               "ready: load acquire", "release: store release", "room: load acquire",
                               "size: load acquire", "size: load acquire", "try_pop: load acquire",
                               "try_pop: store release", "try_push: load acquire",
                               "try_push: store release"});
}

TEST_CASE("a ring that counts one slot too many is caught") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  CHECK(single_steps<OneTooMany<Tracked, 2, Modelled>>(4, 4, 0, true).failures > 0);
}

TEST_CASE("the mailbox is never torn, never runs backwards and never loses the last value") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = latest_value<Mailbox<Tracked, Modelled>>(4, 4, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 1000);
  CHECK(result.failures == 0);
}

TEST_CASE("a mailbox that loads and stores instead of exchanging is caught") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  CHECK(latest_value<Mailbox<Tracked, SplitExchange>>(3, 3, true).failures > 0);
}

TEST_CASE("each memory order of the mailbox is needed, and its loss is caught", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants =
      weaken_each_order([](bool stop) { return latest_value<Mailbox<Tracked, Modelled>>(3, 3, stop); });
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"publish: exchange acquire", "publish: exchange release",
                               "refresh: exchange acquire", "refresh: exchange release"});
}

}  // namespace sortie::rt::test
