// SPDX-License-Identifier: BSD-3-Clause
// A runtime's state to bytes and back, and what stands in the way of that.
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

void Runtime::archive(rt::Archive& archive, rt::Tick tick) {
  executive_->archive(archive, tick);
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    archive.expect(i, "what the tasks remember lies in another order");
    if (!builder_->archive_memory(executive_->task(i), archive))
      archive.fail(Status::not_supported, "a task has not declared what it remembers");
  }
}

std::vector<std::string> Runtime::undeclared_state() const {
  std::vector<std::string> lines;
  for (std::uint32_t i = 0; i < executive_->task_count(); ++i) {
    const rt::TaskBase& task = executive_->task(i);
    const std::string place = "vehicle " + profile_.vehicle() + ", task " + task.name();
    rt::Archive measure = rt::Archive::measuring();
    if (task.hides_state()) {
      lines.push_back(
          place +
          ": its function changes its own captures, which nobody can archive; move them to a member "
          "of the vehicle and name that in VehicleBuilder::remembers()");
    } else if (!builder_->archive_memory(task, measure)) {
      lines.push_back(
          place +
          ": has not declared its state; call VehicleBuilder::remembers(task, object...) with what it "
          "keeps beside its output, or remembers(task) if that is nothing");
    } else if (measure.status() != Status::ok) {
      lines.push_back(place + ": " + measure.where() + ": " + measure.why());
    }
  }
  return lines;
}

}  // namespace sortie::firmware
