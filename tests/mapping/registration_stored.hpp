// SPDX-License-Identifier: BSD-3-Clause
// A part of registration as stored bytes, and back.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/archive.hpp"

namespace sortie::testing {

template <class Part>
std::vector<std::uint8_t> stored(Part& part) {
  rt::Archive measure = rt::Archive::measuring();
  part.archive(measure);
  INFO(measure.where() << ": " << measure.why());
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive write = rt::Archive::writing(bytes);
  part.archive(write);
  REQUIRE(write.status() == Status::ok);
  return bytes;
}

template <class Part>
Status restore(Part& part, std::span<const std::uint8_t> bytes) {
  rt::Archive read = rt::Archive::reading(bytes);
  part.archive(read);
  return read.status();
}

}  // namespace sortie::testing
