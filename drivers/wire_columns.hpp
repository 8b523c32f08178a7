// SPDX-License-Identifier: BSD-3-Clause
// Tables in messages: LCM has no lists of structs that a generic tool shows well, so each member of the rows
// is an array of its own. Internal to the codecs.
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "drivers/wire_cursor.hpp"

namespace sortie::drivers {

/// Writes one member of every row: a number or a std::string. The count is written apart. No heap.
template <class Rows, class Row, class Member>
void put_column(WireWriter& writer, const Rows& rows, Member Row::*member) noexcept {
  for (const Row& row : rows) {
    if constexpr (std::is_same_v<Member, std::string>) {
      writer.put_string(row.*member);
    } else {
      writer.put(row.*member);
    }
  }
}

/// Reads one member of every row; `rows` has its size already, from a count that was held against the bytes
/// left. Texts are copied (heap).
template <class Row, class Member>
void get_column(WireReader& reader, std::vector<Row>& rows, Member Row::*member) {
  for (Row& row : rows) {
    if constexpr (std::is_same_v<Member, std::string>) {
      row.*member = reader.get_string();
    } else {
      row.*member = reader.get<Member>();
    }
  }
}

}  // namespace sortie::drivers
