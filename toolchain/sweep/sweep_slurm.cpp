// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_slurm.hpp"

#include <algorithm>
#include <fstream>

#include "firmware_like/scene/json.hpp"
#include "toolchain/export/output_file.hpp"

namespace sortie::toolchain {

namespace {

// Slurm's MaxArraySize is 1001 where nobody set it; it is one more than the largest index.
constexpr std::size_t kMostTasks = 1000;

std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string note_path(const std::string& folder) { return folder + "/array.json"; }

}  // namespace

std::size_t ArrayScript::tasks() const { return std::min(cells, kMostTasks); }

std::string ArrayScript::text() const {
  const std::string last = std::to_string(tasks() - 1);
  std::string text;
  text += "#!/bin/bash\n";
  text += "#SBATCH --job-name=sortie-sweep\n";
  text += "#SBATCH --array=0-" + last + "\n";
  text += "#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=1\n";
  text += "#SBATCH --output=/dev/null\n";
  text +=
      "# " + std::to_string(cells) + " cells of a sweep. Submit: sbatch FILE. Then: sortie merge FOLDER.\n";
  text += "set -u\nprogram=" + shell_word(program) + "\nfolder=" + shell_word(folder) + "\n";
  text += "if [ -z \"${SLURM_ARRAY_TASK_ID:-}\" ]; then\n";
  text +=
      "  echo \"This is an array script: submit it with sbatch $0. Where sbatch is missing: apt-get "
      "install\" "
      ">&2\n";
  text += "  echo \"slurm-client, or run the cells on this machine: \\\"$program\\\" bench --cell 0-" +
          std::to_string(cells - 1) + " --out \\\"$folder\\\"\" >&2\n";
  text += "  exit 2\nfi\n";
  text += "exec >\"$folder/task-$SLURM_ARRAY_TASK_ID.txt\" 2>&1\n";
  text += "if [ ! -x \"$program\" ]; then\n";
  text +=
      "  echo \"$program is not on this node: put it on a file system that all nodes see, then plan "
      "again\"\n";
  text += "  exit 2\nfi\n";
  text += "failed=0\nfor ((cell = SLURM_ARRAY_TASK_ID; cell < " + std::to_string(cells) +
          "; cell += " + std::to_string(tasks()) + ")); do\n";
  text += "  \"$program\" bench --cell \"$cell\" --out \"$folder\" || failed=1\ndone\nexit $failed\n";
  return text;
}

std::string cell_list(const std::vector<std::size_t>& cells) {
  std::string list;
  for (std::size_t i = 0; i < cells.size();) {
    std::size_t end = i + 1;
    while (end < cells.size() && cells[end] == cells[end - 1] + 1) ++end;
    list += (list.empty() ? "" : ",") + std::to_string(cells[i]);
    if (end - i > 1) list += "-" + std::to_string(cells[end - 1]);
    i = end;
  }
  return list;
}

void remember_script(const std::string& folder, const std::string& script_path, const ArrayScript& script) {
  const firmware::Json note{{"script", script_path}, {"tasks", script.tasks()}};
  write_file(note_path(folder), note.dump() + "\n");
}

std::vector<std::string> resubmit_command(const std::string& program, const std::string& folder,
                                          const std::vector<std::size_t>& missing) {
  std::ifstream in(note_path(folder), std::ios::binary);
  const auto note = firmware::Json::parse_or_null(in);
  if (!note.is_object() || !note.contains("script") || !note.contains("tasks"))
    return {program, "bench", "--cell", cell_list(missing), "--out", folder};
  const auto count = std::max<std::size_t>(1, note["tasks"].get<std::size_t>());
  std::vector<std::size_t> tasks;
  for (const std::size_t cell : missing) tasks.push_back(cell % count);
  std::sort(tasks.begin(), tasks.end());
  tasks.erase(std::unique(tasks.begin(), tasks.end()), tasks.end());
  return {"sbatch", "--array=" + cell_list(tasks), note["script"].get<std::string>()};
}

}  // namespace sortie::toolchain
