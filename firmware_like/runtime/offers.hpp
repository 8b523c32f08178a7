// SPDX-License-Identifier: BSD-3-Clause
// What the parts of a vehicle hand each other while it is built.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sortie::firmware {

/// Objects by type and name, of whoever put them here. Set-up only: on the heap, finding is linear.
class Offers {
 public:
  template <class T>
  void put(std::string_view name, T* thing) {
    things_.push_back({&kKey<T>, std::string(name), thing});
  }
  /// The first that was put here as a T of that name, or null.
  template <class T>
  T* find(std::string_view name) const {
    for (const Thing& thing : things_) {
      if (thing.type == &kKey<T> && thing.name == name) return static_cast<T*>(thing.object);
    }
    return nullptr;
  }

 private:
  // Its address stands for the type: a type's own name would tie code to what another build may lack.
  template <class T>
  static inline char kKey{};

  struct Thing {
    const char* type;
    std::string name;
    void* object;
  };
  std::vector<Thing> things_;
};

}  // namespace sortie::firmware
