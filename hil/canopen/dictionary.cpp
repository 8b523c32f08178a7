// SPDX-License-Identifier: BSD-3-Clause
#include "hil/canopen/dictionary.hpp"

#include <algorithm>

#include "drivers/canopen/cia402.hpp"
#include "drivers/canopen/drive_setup.hpp"

namespace sortie::hil {

namespace canopen = drivers::canopen;
using canopen::ObjectKey;

void CanopenDictionary::reset() noexcept {
  objects_.clear();
  add(0x1000, 0, 4, false, false, 0x0002'0000u | canopen::kDriveProfile);  // a servo drive
  add(0x1001, 0, 1, false, true, 0);
  add(0x1016, 0, 1, false, false, 1);
  add(0x1016, 1, 4, true, false, 0);
  add(0x1017, 0, 2, true, false, 0);
  add(0x1400, 1, 4, true, false, canopen::kRpdo1Id + node_);
  add(0x1029, 1, 1, true, false, 0);  // a lost connection leads to pre-operational
  add(0x1400, 2, 1, true, false, canopen::kPdoAtOnce);
  add(0x1400, 5, 2, true, false, 0);  // ms without a command: a fault
  add(0x1600, 0, 1, true, false, 1);
  for (std::uint8_t i = 1; i <= 4; ++i) add(0x1600, i, 4, true, false, i == 1 ? 0x6040'0010u : 0u);
  add(0x1800, 1, 4, true, false, canopen::kPdoNoRemote | (canopen::kTpdo1Id + node_));
  add(0x1800, 2, 1, true, false, canopen::kPdoAtOnce);
  add(0x1A00, 0, 1, true, false, 1);
  for (std::uint8_t i = 1; i <= 4; ++i) add(0x1A00, i, 4, true, false, i == 1 ? 0x6041'0010u : 0u);
  add(canopen::kAbortOption, 0, 2, true, false, 1);
  add(0x605A, 0, 2, true, false, 1);  // a quick stop is a slow one until somebody asks for another
  add(0x605E, 0, 2, true, false, 2);
  add(0x6065, 0, 4, true, false, 0);
  add(0x6066, 0, 2, true, false, 0);
  add(0x6083, 0, 4, true, false, kUsualRamp);
  add(0x6084, 0, 4, true, false, kUsualRamp / 4);
  add(0x6085, 0, 4, true, false, kUsualRamp / 4);
  add(canopen::kControlWord, 0, 2, true, true, 0);
  add(canopen::kStatusWord, 0, 2, false, true, 0);
  add(canopen::kModeWanted, 0, 1, true, true, 0);
  add(canopen::kModeShown, 0, 1, false, true, 0);
  add(canopen::kPositionActual, 0, 4, false, true, 0);
  add(canopen::kVelocityActual, 0, 4, false, true, 0);
  add(canopen::kTorqueActual, 0, 2, false, true, 0);
  add(canopen::kTargetPosition, 0, 4, true, true, 0);
  add(canopen::kTargetVelocity, 0, 4, true, true, 0);
  add(0x60C2, 1, 1, true, false, 1);
  add(0x60C2, 2, 1, true, false, 0xFD);
}

void CanopenDictionary::add(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, bool writable,
                            bool mappable, std::uint32_t value) noexcept {
  static_cast<void>(objects_.push_back({{index, sub}, bytes, writable, mappable, value}));
}

CanopenObject* CanopenDictionary::find(ObjectKey key) noexcept {
  CanopenObject* const found = std::ranges::find(objects_, key, &CanopenObject::key);
  return found == objects_.end() ? nullptr : found;
}

const CanopenObject* CanopenDictionary::find(ObjectKey key) const noexcept {
  const CanopenObject* const found = std::ranges::find(objects_, key, &CanopenObject::key);
  return found == objects_.end() ? nullptr : found;
}

std::uint32_t CanopenDictionary::value(std::uint16_t index, std::uint8_t sub) const noexcept {
  const CanopenObject* object = find({index, sub});
  return object == nullptr ? 0 : object->value;
}

void CanopenDictionary::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) noexcept {
  if (CanopenObject* object = find({index, sub})) object->value = value;
}

void CanopenDictionary::remove(std::uint16_t index, std::uint8_t sub) noexcept {
  CanopenObject* const object = find({index, sub});
  if (object == nullptr) return;
  *object = objects_.back();
  objects_.pop_back();
}

std::uint32_t CanopenDictionary::read(ObjectKey key, std::uint32_t& value,
                                      std::uint8_t& bytes) const noexcept {
  const CanopenObject* object = find(key);
  if (object == nullptr) return canopen::kAbortNoObject;
  value = object->value;
  bytes = object->bytes;
  return 0;
}

std::uint32_t CanopenDictionary::write(ObjectKey key, std::uint32_t value, std::uint8_t bytes,
                                       bool operational) noexcept {
  CanopenObject* object = find(key);
  if (object == nullptr) return canopen::kAbortNoObject;
  if (!object->writable) return canopen::kAbortReadOnly;
  if (bytes != 0 && bytes != object->bytes) return canopen::kAbortSize;
  if (object->bytes < 4) value &= (1u << 8u * object->bytes) - 1u;  // all four came without a size
  if (const std::uint32_t code = refuse_mapping(key, value, operational)) return code;
  object->value = value;
  return 0;
}

// CiA 301, 7.5.2.36: a mapping changes while its PDO does not exist and its count is 0; the identifier while
// the PDO does not exist, or in the write that takes it away.
std::uint32_t CanopenDictionary::refuse_mapping(ObjectKey key, std::uint32_t value,
                                                bool operational) const noexcept {
  const bool communication = key.index == 0x1400 || key.index == 0x1800;
  const bool mapping = key.index == 0x1600 || key.index == 0x1A00;
  if (!communication && !mapping) return 0;
  if (operational) return canopen::kAbortState;
  const std::uint16_t pdo = communication ? key.index : static_cast<std::uint16_t>(key.index - 0x200);
  const bool off = (this->value(pdo, 1) & canopen::kPdoOff) != 0;
  if (communication && key.sub == 1) return off || (value & canopen::kPdoOff) != 0 ? 0 : canopen::kAbortValue;
  if (!off) return canopen::kAbortState;
  if (!mapping) return 0;
  if (key.sub == 0) {
    unsigned bits = 0;
    for (std::uint8_t i = 1; i <= value && i <= 4; ++i) bits += this->value(key.index, i) & 0xFFu;
    return value <= 4 && bits <= 64 ? 0 : canopen::kAbortValue;
  }
  if (this->value(key.index, 0) != 0) return canopen::kAbortState;
  const CanopenObject* target =
      find({static_cast<std::uint16_t>(value >> 16u), static_cast<std::uint8_t>(value >> 8u & 0xFFu)});
  const bool good = target != nullptr && target->mappable && (value & 0xFFu) == target->bytes * 8u;
  return good ? 0 : canopen::kAbortNotMappable;
}

std::uint8_t CanopenDictionary::pack(std::uint16_t mapping, drivers::CanFrame& frame) const noexcept {
  unsigned used = 0;
  for (std::uint8_t i = 1; i <= value(mapping, 0); ++i) {
    const std::uint32_t entry = value(mapping, i);
    const unsigned bytes = (entry & 0xFFu) / 8u;
    canopen::write_le(
        frame, used, bytes,
        value(static_cast<std::uint16_t>(entry >> 16u), static_cast<std::uint8_t>(entry >> 8u & 0xFFu)));
    used += bytes;
  }
  return static_cast<std::uint8_t>(used);
}

std::uint8_t CanopenDictionary::unpack(std::uint16_t mapping, const drivers::CanFrame& frame) noexcept {
  unsigned needed = 0;
  for (std::uint8_t i = 1; i <= value(mapping, 0); ++i) needed += (value(mapping, i) & 0xFFu) / 8u;
  if (frame.size < needed) return 0;
  unsigned used = 0;
  for (std::uint8_t i = 1; i <= value(mapping, 0); ++i) {
    const std::uint32_t entry = value(mapping, i);
    const unsigned bytes = (entry & 0xFFu) / 8u;
    set(static_cast<std::uint16_t>(entry >> 16u), static_cast<std::uint8_t>(entry >> 8u & 0xFFu),
        canopen::read_le(frame, used, bytes));
    used += bytes;
  }
  return static_cast<std::uint8_t>(used);
}

}  // namespace sortie::hil
