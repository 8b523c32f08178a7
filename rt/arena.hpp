// SPDX-License-Identifier: BSD-3-Clause
// All memory of the runtime is taken here at start-up, by name, so that it can be listed and checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>

#include "rt/limits.hpp"

namespace sortie::rt {

/// What one named allocation took. Names longer than 47 characters are cut.
struct PoolRecord {
  char name[48]{};
  std::uint64_t capacity{};       ///< elements
  std::uint64_t element_bytes{};  ///< bytes of one element
  std::uint64_t bytes{};          ///< bytes taken, alignment gap included
  bool refused{};                 ///< true: there was no room; nothing was taken
};

/// Bump allocator over one block of memory that belongs to the caller and outlives it. Start-up only: nothing
/// is given back, and no destructors run, so elements must be trivially destructible. Never throws; what was
/// refused stands in the report, with needed_bytes() as the cure.
class Arena {
 public:
  /// An arena over `memory`, which may have any alignment.
  explicit Arena(std::span<std::byte> memory) : memory_(memory) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// `capacity` value-initialised elements under a name, aligned for T and at least to `alignment` (a power
  /// of two). An empty span when there is no room (see refused()) or when capacity is 0.
  template <class T>
  [[nodiscard]] std::span<T> make_array(const char* name, std::size_t capacity,
                                        std::size_t alignment = alignof(T)) {
    static_assert(std::is_trivially_destructible_v<T>, "an arena runs no destructors");
    static_assert(std::is_nothrow_default_constructible_v<T>, "an arena has no way back from an exception");
    std::byte* const raw = take(name, capacity, sizeof(T), alignment > alignof(T) ? alignment : alignof(T));
    if (raw == nullptr) return {};
    T* const elements = reinterpret_cast<T*>(raw);
    for (std::size_t i = 0; i < capacity; ++i) new (raw + i * sizeof(T)) T();
    return {elements, capacity};
  }

  /// From here on the arena ends at `bytes`, but behind all that was taken; what does not fit is refused.
  void end_at(std::uint64_t bytes) {
    if (bytes < used_) bytes = used_;
    if (bytes < memory_.size()) memory_ = memory_.first(static_cast<std::size_t>(bytes));
  }

  /// Every allocation and every refusal in the order they were asked for.
  std::span<const PoolRecord> report() const { return {records_, records_used_}; }
  /// Bytes taken so far, gaps included.
  std::uint64_t used_bytes() const { return used_; }
  /// Bytes a block would need (counted with worst-case gaps) for all that was asked for, refusals included.
  std::uint64_t needed_bytes() const { return needed_; }
  /// Allocations that were refused: 0 is the only good value after start-up.
  std::uint32_t refused() const { return refused_; }

 private:
  std::byte* take(const char* name, std::size_t capacity, std::size_t element_bytes, std::size_t alignment) {
    const auto start = reinterpret_cast<std::uintptr_t>(memory_.data());
    const std::uintptr_t at = (start + used_ + alignment - 1) & ~(std::uintptr_t{alignment} - 1);
    const std::size_t offset = static_cast<std::size_t>(at - start);
    const bool overflows = element_bytes != 0 && capacity > SIZE_MAX / 2 / element_bytes;
    const std::uint64_t body = std::uint64_t{capacity} * element_bytes;
    const bool listed = records_used_ < kMaxArenaPools;
    const bool fits = !overflows && listed && offset <= memory_.size() && body <= memory_.size() - offset;
    if (listed) {
      PoolRecord& record = records_[records_used_++];
      for (std::size_t i = 0; name != nullptr && i + 1 < sizeof(record.name) && name[i] != '\0'; ++i) {
        record.name[i] = name[i];
      }
      record.capacity = capacity;
      record.element_bytes = element_bytes;
      record.bytes = fits ? offset - used_ + body : 0;
      record.refused = !fits;
    }
    needed_ += body + alignment - 1;
    if (!fits) {
      ++refused_;
      return nullptr;
    }
    used_ = offset + static_cast<std::size_t>(body);
    return capacity == 0 ? nullptr : memory_.data() + offset;
  }

  std::span<std::byte> memory_;
  std::size_t used_{0};
  std::uint64_t needed_{0};
  std::uint32_t refused_{0};
  std::uint32_t records_used_{0};
  PoolRecord records_[kMaxArenaPools]{};
};

}  // namespace sortie::rt
