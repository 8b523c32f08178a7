// SPDX-License-Identifier: BSD-3-Clause
// The latest value for many readers in every interleaving of a writer and one or two readers, under the
// memory model of C++. Each rule of the protocol is broken once, which must be caught.
#include <catch2/catch.hpp>
#include <cstdint>

#include "rt/latest_value.hpp"
#include "tests/rt/model_memory.hpp"
#include "tests/rt/queue_latest_model.hpp"

namespace sortie::rt::test {
namespace {

enum class Slip {
  none,             // as it should be: shows that it is the slip that is caught
  one_slot_less,    // has no free slot when every reader holds an older value
  named_apart,      // reads the newest slot's name first and is counted there afterwards
  leaves_late,      // holds two slots for a moment
  publishes_blind,  // does not look, when publishing, what the readers had left by then
};

// The same once more, as short as possible, with a slip.
template <std::uint32_t kReaders, Slip slip>
class Variant {
 public:
  static constexpr std::uint32_t kSlots = kReaders + (slip == Slip::one_slot_less ? 1 : 2);

  void write(const Tracked& value) {
    std::uint32_t slot = 0;
    while (slot + 1 < kSlots &&
           (slot == newest_ || left_[slot].load(std::memory_order_acquire) != came_[slot])) {
      ++slot;
    }
    values_[slot] = value;
    generations_[slot] = ++generation_;
    const std::uint32_t old = current_.exchange(
        slot, slip == Slip::publishes_blind ? std::memory_order_release : std::memory_order_acq_rel);
    came_[newest_] += old / 256;
    newest_ = slot;
  }

  class Reader {
   public:
    bool read(Tracked& value) {
      const std::uint32_t seen = box->current_.load(std::memory_order_relaxed) % 256;
      const bool fresh = seen != held;
      if (fresh) {
        const std::uint32_t before = held;
        if (slip != Slip::leaves_late) box->left_[before].fetch_add(1, std::memory_order_release);
        held = box->current_.fetch_add(256, std::memory_order_acq_rel) % 256;
        if (slip == Slip::named_apart) held = seen;
        if (slip == Slip::leaves_late) box->left_[before].fetch_add(1, std::memory_order_release);
      }
      value = box->values_[held];
      return fresh;
    }
    std::uint64_t generation() const { return box->generations_[held]; }

    Variant* box{nullptr};
    std::uint32_t held{0};
  };

  Reader* reader(std::uint32_t index) {
    readers_[index].box = this;
    return &readers_[index];
  }

 private:
  Tracked values_[kSlots];
  std::uint64_t generations_[kSlots]{};
  Modelled<std::uint32_t> left_[kSlots];
  std::uint32_t came_[kSlots]{};
  Modelled<std::uint32_t> current_{kReaders * 256};
  std::uint32_t newest_{0};
  std::uint64_t generation_{0};
  Reader readers_[kReaders];
};

}  // namespace

TEST_CASE("the latest value is never torn and never runs backwards for one reader in any interleaving") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = many_readers<LatestValue<Tracked, 1, Modelled>>(4, {4}, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 1000);
  CHECK(result.failures == 0);
}

TEST_CASE("the latest value is never torn and never runs backwards for two readers in any interleaving",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result result = many_readers<LatestValue<Tracked, 2, Modelled>>(2, {2, 1}, false);
  INFO(result.executions << " executions");
  CHECK(result.executions > 1000);
  CHECK(result.failures == 0);
}

TEST_CASE("each slip in a latest value for many readers is caught") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  CHECK(many_readers<Variant<1, Slip::none>>(3, {2}, false).failures == 0);
  CHECK(many_readers<Variant<1, Slip::one_slot_less>>(3, {2}, true).failures > 0);
  CHECK(many_readers<Variant<1, Slip::named_apart>>(3, {2}, true).failures > 0);
  CHECK(many_readers<Variant<1, Slip::leaves_late>>(4, {3}, true).failures > 0);
  CHECK(many_readers<Variant<1, Slip::publishes_blind>>(4, {3}, true).failures > 0);
  CHECK(many_readers<LatestValue<Tracked, 1, SplitExchange>>(3, {2}, true).failures > 0);
}

TEST_CASE("each memory order of the latest value is needed, and its loss is caught", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order(
      [](bool stop) { return many_readers<LatestValue<Tracked, 1, Modelled>>(4, {3}, stop); });
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"free_slot: load acquire", "publish: exchange acquire",
                               "publish: exchange release", "refresh: fetch_add acquire",
                               "refresh: fetch_add release", "refresh: fetch_add release"});
}

}  // namespace sortie::rt::test
