// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/stored_cells.hpp"

#include <charconv>
#include <stdexcept>

namespace sortie::firmware {

namespace {

constexpr std::string_view kLetters = "ufb";

[[noreturn]] void fail(std::size_t at, const std::string& why) {
  throw std::invalid_argument("character " + std::to_string(at + 1) + ": " + why);
}

}  // namespace

std::string pack_cells(std::span<const CellState> cells) {
  std::string text;
  for (std::size_t i = 0; i < cells.size();) {
    std::size_t end = i + 1;
    while (end < cells.size() && cells[end] == cells[i]) ++end;
    text += kLetters[static_cast<std::size_t>(cells[i])];
    text += std::to_string(end - i);
    i = end;
  }
  return text;
}

std::vector<CellState> unpack_cells(std::string_view text, std::size_t count) {
  std::vector<CellState> cells;
  cells.reserve(count);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t letter = kLetters.find(text[at]);
    if (letter == std::string_view::npos) fail(at, "must be u, f or b, with a number of cells behind it");
    std::uint64_t run = 0;
    const char* const end = text.data() + text.size();
    const auto [next, error] = std::from_chars(text.data() + at + 1, end, run);
    if (error != std::errc{} || run == 0) fail(at + 1, "must be a number of cells, from 1 on");
    if (run > count - cells.size())
      fail(at + 1, "more cells than the map's " + std::to_string(count) + "; was it made for another size?");
    cells.insert(cells.end(), static_cast<std::size_t>(run), static_cast<CellState>(letter));
    at = static_cast<std::size_t>(next - text.data());
  }
  if (cells.size() != count) {
    fail(text.size(), "the text ends after " + std::to_string(cells.size()) + " of the map's " +
                          std::to_string(count) + " cells; was it made for another size?");
  }
  return cells;
}

}  // namespace sortie::firmware
