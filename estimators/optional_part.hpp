// SPDX-License-Identifier: BSD-3-Clause
// A part that is there or not, and whose memory is taken only where it is.
#pragma once

#include <memory>

namespace sortie::estimators {

/// Like std::optional, but without room for a value that is not there: made once, at construction of its
/// owner, on the heap. Copies are copies of the value; copying into another one takes memory.
template <class T>
class OptionalPart {
 public:
  OptionalPart() = default;
  OptionalPart(const OptionalPart& other)
      : part_(other.part_ ? std::make_unique<T>(*other.part_) : nullptr) {}
  OptionalPart(OptionalPart&&) noexcept = default;
  OptionalPart& operator=(const OptionalPart& other) {
    if (this != &other) part_ = other.part_ ? std::make_unique<T>(*other.part_) : nullptr;
    return *this;
  }
  OptionalPart& operator=(OptionalPart&&) noexcept = default;
  ~OptionalPart() = default;

  template <class... Arguments>
  void make(const Arguments&... arguments) {
    part_ = std::make_unique<T>(arguments...);
  }
  explicit operator bool() const { return part_ != nullptr; }
  T* operator->() { return part_.get(); }
  const T* operator->() const { return part_.get(); }

 private:
  std::unique_ptr<T> part_;
};

}  // namespace sortie::estimators
