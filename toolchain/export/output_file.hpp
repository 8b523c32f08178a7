// SPDX-License-Identifier: BSD-3-Clause
// Writing a file so that it is either whole or not there.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace sortie::toolchain {

/// Calls `write` with a stream and puts what it wrote at `name`; "-" is standard output. The file gets its
/// name only when all was written. Throws InputError (path, reason, cure) if the system refuses; what `write`
/// throws passes through. In both cases nothing is left behind.
void write_file(const std::string& name, const std::function<void(std::ostream&)>& write);
/// The same of a text.
void write_file(const std::string& name, const std::string& text);

}  // namespace sortie::toolchain
