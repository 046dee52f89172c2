#include "capture/shoot/simulation/fault_plan.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

const std::vector<std::string> kFaultKinds = {
    "lost-reply", "lost-line", "garbage",   "stall",   "unplug",  "reset",           "mute",
    "battery",    "half-file", "card-full", "blurred", "grabbed", "camera-unplugged"};

std::vector<PlannedFault> ParseFaults(const std::string& text) {
  std::vector<PlannedFault> faults;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const std::size_t sign = word.find('@');
    PlannedFault fault{word.substr(0, sign), 0};
    if (std::find(kFaultKinds.begin(), kFaultKinds.end(), fault.kind) == kFaultKinds.end())
      throw UsageError("--faults: '" + fault.kind + "' is not known; did you mean '" +
                       NearestWord(fault.kind, kFaultKinds) + "'?");
    const char* const end = word.data() + word.size();
    const char* const begin = sign == std::string::npos ? end : word.data() + sign + 1;
    const auto [last, error] = std::from_chars(begin, end, fault.at);
    if (error != std::errc() || last != end || fault.at < 1)
      throw UsageError("--faults: '" + word + "' needs the number of a move or a release, as in " +
                       fault.kind + "@5");
    faults.push_back(fault);
  }
  return faults;
}

bool FaultPlan::Due(const std::string& kind, int count) {
  const std::lock_guard lock(mutex_);
  const auto due = std::find_if(faults_.begin(), faults_.end(), [&](const PlannedFault& fault) {
    return fault.kind == kind && fault.at == count;
  });
  if (due == faults_.end()) return false;
  faults_.erase(due);
  return true;
}

}  // namespace keypose::capture::shoot
