// SPDX-License-Identifier: BSD-3-Clause
// The object dictionary of a simulated drive: what may be read, written and mapped, with sizes and ranges.
#pragma once

#include <cstdint>

#include "drivers/canopen/frames.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::hil {

/// One object.
struct CanopenObject {
  drivers::canopen::ObjectKey key{};
  std::uint8_t bytes{};
  bool writable{};
  bool mappable{};
  std::uint32_t value{};
};

/// Ramps that a drive has until it is given others, increments/s^2.
inline constexpr std::uint32_t kUsualRamp = 40'000;

/// All objects of one drive. No heap.
class CanopenDictionary {
 public:
  explicit CanopenDictionary(std::uint8_t node) : node_(node) { reset(); }
  /// As after power-on.
  void reset() noexcept;

  /// 0 or the abort code of CiA 301.
  std::uint32_t read(drivers::canopen::ObjectKey key, std::uint32_t& value,
                     std::uint8_t& bytes) const noexcept;
  /// The same; `operational`: mappings cannot change then.
  std::uint32_t write(drivers::canopen::ObjectKey key, std::uint32_t value, std::uint8_t bytes,
                      bool operational) noexcept;

  /// Value of an object that exists, else 0.
  std::uint32_t value(std::uint16_t index, std::uint8_t sub = 0) const noexcept;
  /// The drive's own changes; an object that does not exist stays so.
  void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) noexcept;
  /// For tests: takes an object away, as in a drive that does not have it.
  void remove(std::uint16_t index, std::uint8_t sub) noexcept;

  /// Packs (or unpacks) the objects that `mapping` names into a frame's data; bytes used. Unpacking a frame
  /// that is too short changes nothing and gives 0.
  std::uint8_t pack(std::uint16_t mapping, drivers::CanFrame& frame) const noexcept;
  std::uint8_t unpack(std::uint16_t mapping, const drivers::CanFrame& frame) noexcept;

 private:
  CanopenObject* find(drivers::canopen::ObjectKey key) noexcept;
  const CanopenObject* find(drivers::canopen::ObjectKey key) const noexcept;
  void add(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, bool writable, bool mappable,
           std::uint32_t value) noexcept;
  std::uint32_t refuse_mapping(drivers::canopen::ObjectKey key, std::uint32_t value,
                               bool operational) const noexcept;

  rt::FixedVector<CanopenObject, 50> objects_;
  std::uint8_t node_;
};

}  // namespace sortie::hil
