// SPDX-License-Identifier: BSD-3-Clause
// What a vehicle keeps of a part that this build may lack.
#pragma once

#include <memory>
#include <type_traits>

#include "rt/built_parts.hpp"

namespace sortie::firmware {

/// In the place of a std::unique_ptr to a part whose code is not in this build: always null. It neither makes
/// nor destroys a T, so that nothing refers to T's code.
template <class T>
struct AbsentPart {
  AbsentPart& operator=(std::unique_ptr<T>&&) { return *this; }
  explicit constexpr operator bool() const { return false; }
  T* operator->() const { return nobody; }
  T* get() const { return nobody; }
  T* nobody{};
};

/// A std::unique_ptr<T> where `part` is built.
template <class T, rt::PartName part>
using OwnedPart = std::conditional_t<rt::kBuilt<part>, std::unique_ptr<T>, AbsentPart<T>>;

}  // namespace sortie::firmware
