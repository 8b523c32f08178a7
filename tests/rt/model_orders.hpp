// SPDX-License-Identifier: BSD-3-Clause
// Takes the memory orders of a modelled type away, one half of one operation at a time. An order that nothing
// misses is either not needed, or its model has too small a program: both are found here, never on x86.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tests/rt/interleaving.hpp"

namespace sortie::rt::test {

/// Where an atomic operation stands in the code under test.
struct Caller {
  const char* function;
  const char* file;
  int line;

  // As a default argument it names the place of the call.
  static constexpr Caller here(const char* function = __builtin_FUNCTION(),
                               const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    return {function, file, line};
  }
};

/// One half of the order of one operation.
struct OrderSite {
  Caller where;
  const char* operation;  ///< "load acquire", "store release", "exchange acquire" and so on

  bool operator==(const OrderSite& other) const {
    return where.line == other.where.line && std::strcmp(operation, other.operation) == 0 &&
           std::strcmp(where.file, other.where.file) == 0;
  }
  std::string name() const {
    const std::string function = where.function;
    return function.substr(0, function.find('<')) + ": " + operation;
  }
};

/// The orders that a model has met, and the one that is taken away.
class Orders {
 public:
  static Orders& instance() {
    static Orders orders;
    return orders;
  }

  /// Asked by the model at each half of an order: false where a plant has taken it away.
  bool holds(const OrderSite& site) {
    if (collects_ && std::find(sites_.begin(), sites_.end(), site) == sites_.end()) sites_.push_back(site);
    return taken_ == nullptr || !(*taken_ == site);
  }

  /// From now on the sites are noted.
  void collect() {
    sites_.clear();
    collects_ = true;
  }
  std::vector<OrderSite> collected() {
    collects_ = false;
    return sites_;
  }
  /// Takes one order away, or none (null).
  void take_away(const OrderSite* site) { taken_ = site; }

 private:
  std::vector<OrderSite> sites_;
  const OrderSite* taken_{nullptr};
  bool collects_{false};
};

/// Of orders: "function: operation half", sorted.
using Names = std::vector<std::string>;

/// What came of a type as it is, and of each order that was taken away.
struct OrderPlants {
  Result as_it_is;
  Names caught;  ///< without these something failed
  Names missed;  ///< nothing noticed that these were gone
};

/// `run(stop_at_failure)` explores one or more programs of the type and gives a Result. It is run as it is,
/// then once for each half of each order that was met, weakened to relaxed.
template <class Run>
OrderPlants weaken_each_order(Run run) {
  Orders& orders = Orders::instance();
  OrderPlants plants;
  orders.collect();
  plants.as_it_is = run(false);
  for (const OrderSite& site : orders.collected()) {
    orders.take_away(&site);
    (run(true).failures != 0 ? plants.caught : plants.missed).push_back(site.name());
    orders.take_away(nullptr);
  }
  std::sort(plants.caught.begin(), plants.caught.end());
  std::sort(plants.missed.begin(), plants.missed.end());
  return plants;
}

}  // namespace sortie::rt::test
