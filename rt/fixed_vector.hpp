// SPDX-License-Identifier: BSD-3-Clause
// A vector with inline storage of fixed size: for lists whose longest length is a promise.
#pragma once

#include <cstdint>
#include <type_traits>

namespace sortie::rt {

/// Up to N elements in place, in order. No heap, no exception: what does not fit is refused. Memory: N *
/// sizeof(T) + 4. All N elements exist at all times (value-initialised), so T is a plain value.
template <class T, std::uint32_t N>
class FixedVector {
  static_assert(N > 0, "a vector that can hold nothing is a mistake");
  static_assert(std::is_trivially_destructible_v<T>, "elements are plain values");

 public:
  using value_type = T;

  /// Appends a copy. False, and nothing changed, when full.
  [[nodiscard]] constexpr bool push_back(const T& value) {
    if (size_ == N) return false;
    elements_[size_++] = value;
    return true;
  }
  /// Drops the last element; nothing when empty.
  constexpr void pop_back() {
    if (size_ != 0) --size_;
  }
  /// Drops element `i` and closes the gap, keeping the order. O(n). Nothing when out of range.
  constexpr void erase(std::uint32_t i) {
    if (i >= size_) return;
    for (std::uint32_t k = i + 1; k < size_; ++k) elements_[k - 1] = elements_[k];
    --size_;
  }
  /// Drops all elements.
  constexpr void clear() { size_ = 0; }
  /// Sets the length; new elements are T{}. False, and nothing changed, when `size` is above N.
  [[nodiscard]] constexpr bool resize(std::uint32_t size) {
    if (size > N) return false;
    for (std::uint32_t i = size_; i < size; ++i) elements_[i] = T{};
    size_ = size;
    return true;
  }

  /// Element `i` < size(); not checked.
  constexpr T& operator[](std::uint32_t i) { return elements_[i]; }
  constexpr const T& operator[](std::uint32_t i) const { return elements_[i]; }
  /// Element `i`, or nullptr when out of range.
  constexpr const T* at(std::uint32_t i) const { return i < size_ ? elements_ + i : nullptr; }
  /// The last element of a vector that is not empty; not checked.
  constexpr T& back() { return elements_[size_ - 1]; }
  constexpr const T& back() const { return elements_[size_ - 1]; }

  constexpr T* data() { return elements_; }
  constexpr const T* data() const { return elements_; }
  constexpr T* begin() { return elements_; }
  constexpr const T* begin() const { return elements_; }
  constexpr T* end() { return elements_ + size_; }
  constexpr const T* end() const { return elements_ + size_; }

  /// Elements inside.
  constexpr std::uint32_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr bool full() const { return size_ == N; }
  /// Elements that fit.
  static constexpr std::uint32_t capacity() { return N; }

 private:
  T elements_[N]{};
  std::uint32_t size_{0};
};

}  // namespace sortie::rt
