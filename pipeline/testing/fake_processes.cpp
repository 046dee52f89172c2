#include "pipeline/testing/fake_processes.h"

#include <algorithm>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::pipeline {

int FakeProcesses::Start(const Command& command) {
  FakeCall call;
  call.program = command.arguments[0];
  call.log = command.log;
  for (std::size_t i = 1; i + 1 < command.arguments.size(); i += 2) {
    call.flags[command.arguments[i].substr(2)].push_back(command.arguments[i + 1]);
  }
  for (const std::string& entry : command.environment)
    call.environment[entry.substr(0, entry.find('='))] = entry.substr(entry.find('=') + 1);
  calls.push_back(call);
  running_[next_id_] = {call, clock_.Now() + stages.at(call.program).seconds};
  most_at_once = std::max(most_at_once, SizeOf(running_));
  return next_id_++;
}

std::vector<ProcessEvent> FakeProcesses::Wait(double) {
  if (running_.empty()) return {};
  const auto first =
      std::min_element(running_.begin(), running_.end(),
                       [](const auto& a, const auto& b) { return a.second.end < b.second.end; });
  const Process process = first->second;
  ProcessEvent event;
  event.id = first->first;
  running_.erase(first);
  clock_.Advance(std::max(0.0, process.end - clock_.Now()));
  const FakeStage& stage = stages.at(process.call.program);
  disk_.Write(process.call.log, "");
  event.exit_code = stage.run(process.call, disk_);
  event.peak_bytes = stage.peak_bytes;
  if (++ended_ == interrupt_after) interrupted_ = true;
  return {event};
}

std::vector<ProcessRunner::Answer> FakeProcesses::Ask(
    const std::vector<std::vector<std::string>>& commands) {
  std::vector<Answer> answers;
  for (const auto& command : commands) {
    ++asked;
    const auto it = stages.find(command[0]);
    if (it == stages.end()) {
      answers.push_back({127, "", "no such program"});
    } else if (command.at(1) == "--check_options") {
      checked.push_back(command);
      answers.push_back({it->second.refused.empty() ? 0 : 2, "", it->second.refused});
    } else {
      answers.push_back({0, it->second.describe.dump(), ""});
    }
  }
  return answers;
}

std::optional<std::filesystem::path> FakeProcesses::FindTool(const std::string& name) const {
  const auto it = tools.find(name);
  return it == tools.end() ? std::nullopt : std::optional(it->second);
}

}  // namespace keypose::pipeline
