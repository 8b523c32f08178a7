// SPDX-License-Identifier: BSD-3-Clause
// The main function of every test binary. Catch2 compiles slowly, so this file is compiled once and shared.
#define CATCH_CONFIG_MAIN
#define CATCH_CONFIG_CONSOLE_WIDTH 200  // Reasons for skipping stay on one line.
#include <catch2/catch.hpp>
