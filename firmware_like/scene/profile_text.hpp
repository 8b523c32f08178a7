// SPDX-License-Identifier: BSD-3-Clause
// What is looked at in the text of a profile before the TOML library sees it.
#pragma once

#include <cstddef>
#include <string_view>

namespace sortie::firmware {

/// Line, from 1, of the first byte above 127 that stands neither in quotes nor in a comment, where TOML has
/// none; 0: there is none. The library (toml++ 3.3) takes such a character for one that cannot occur, and
/// what follows is undefined: found by fuzzing. A byte order mark at the beginning is allowed. Linear, no
/// memory.
std::size_t line_of_bare_non_ascii(std::string_view toml);

/// Whether the bytes are UTF-8: no stray or missing continuations, nothing longer than it need be, no
/// surrogates, none beyond U+10FFFF. Linear, no memory.
bool is_utf8(std::string_view text);

}  // namespace sortie::firmware
