// SPDX-License-Identifier: BSD-3-Clause
// The list of a struct's fields (rt/fields.hpp) in one line, where tables and logs use the members' names.
#pragma once

#include "rt/fields.hpp"

// Each scan of the preprocessor resolves one level of SORTIE_FIELD_NEXT; 256 scans are enough for 256 fields.
#define SORTIE_FIELD_SCAN(...) \
  SORTIE_FIELD_SCAN4(SORTIE_FIELD_SCAN4(SORTIE_FIELD_SCAN4(SORTIE_FIELD_SCAN4(__VA_ARGS__))))
#define SORTIE_FIELD_SCAN4(...) \
  SORTIE_FIELD_SCAN3(SORTIE_FIELD_SCAN3(SORTIE_FIELD_SCAN3(SORTIE_FIELD_SCAN3(__VA_ARGS__))))
#define SORTIE_FIELD_SCAN3(...) \
  SORTIE_FIELD_SCAN2(SORTIE_FIELD_SCAN2(SORTIE_FIELD_SCAN2(SORTIE_FIELD_SCAN2(__VA_ARGS__))))
#define SORTIE_FIELD_SCAN2(...) \
  SORTIE_FIELD_SCAN1(SORTIE_FIELD_SCAN1(SORTIE_FIELD_SCAN1(SORTIE_FIELD_SCAN1(__VA_ARGS__))))
#define SORTIE_FIELD_SCAN1(...) __VA_ARGS__
#define SORTIE_FIELD_EMPTY ()
#define SORTIE_FIELD_ONE(name, ...) \
  visit(#name, self.name);          \
  __VA_OPT__(SORTIE_FIELD_NEXT SORTIE_FIELD_EMPTY(__VA_ARGS__))
#define SORTIE_FIELD_NEXT() SORTIE_FIELD_ONE

/// Inside a fields() that is written by hand: these fields under their own names.
#define SORTIE_VISIT(...) SORTIE_FIELD_SCAN(SORTIE_FIELD_ONE(__VA_ARGS__))

/// Inside a struct: SORTIE_FIELDS(stamp_ns, gas_ppm) makes it rt::Described, with these fields in this order
/// under their own names. At most 256 fields. A field that is left out is in no digest, no log and no table.
#define SORTIE_FIELDS(...)                                    \
  template <class Self, class Visitor>                        \
  static constexpr void fields(Self& self, Visitor&& visit) { \
    SORTIE_VISIT(__VA_ARGS__)                                 \
  }
