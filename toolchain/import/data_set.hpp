// SPDX-License-Identifier: BSD-3-Clause
// Finding the files of a data set from its folder or from one of its files.
#pragma once

#include <string>
#include <vector>

namespace sortie::toolchain {

/// Files named *`ending` in the folder `path` (sorted by name), or `path` itself if it is a file with that
/// ending. Throws InputError if `path` does not exist, or is a file with another ending and `other_endings`
/// (parts of the same set) does not hold it: then the sibling with `ending` is given.
std::vector<std::string> find_files(const std::string& path, const std::string& ending,
                                    const std::vector<std::string>& other_endings = {});

/// The one data set in `path`: the common front of its file names, up to `ending`. Throws InputError if there
/// is none, or several (then the message lists them, exit code 2).
std::string find_set(const std::string& path, const std::string& ending,
                     const std::vector<std::string>& other_endings, const char* kind);

}  // namespace sortie::toolchain
