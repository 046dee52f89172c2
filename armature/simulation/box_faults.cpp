#include "armature/simulation/box_faults.h"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <sstream>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

const std::map<std::string, FaultKind>& Kinds() {
  static const std::map<std::string, FaultKind> kinds = {
      {"drop", FaultKind::kDrop},   {"noise", FaultKind::kNoise}, {"glitch", FaultKind::kGlitch},
      {"wrap", FaultKind::kWrap},   {"stuck", FaultKind::kStuck}, {"unplug", FaultKind::kUnplug},
      {"power", FaultKind::kPower}, {"lost", FaultKind::kLost}};
  return kinds;
}

bool NeedsJoint(FaultKind kind) {
  return kind == FaultKind::kGlitch || kind == FaultKind::kStuck || kind == FaultKind::kLost;
}

int SensorOf(const std::string& joint, const std::string& word, const Armature& armature) {
  std::vector<std::string> names;
  for (const int node : armature.joints)
    names.push_back(armature.nodes[static_cast<std::size_t>(node)].name);
  if (joint.empty())
    throw UsageError(
        fmt::format("--faults: '{}' needs a joint, as in stuck:{}@20", word, names[0]));
  const int node = armature.Find(joint);
  if (node < 0 || armature.JointOf(node) < 0)
    throw UsageError(fmt::format("--faults: the armature has no joint '{}'; did you mean '{}'?",
                                 joint, NearestWord(joint, names)));
  return armature.nodes[static_cast<std::size_t>(node)].sensor;
}

PlannedFault FaultOf(const std::string& word, const Armature& armature) {
  const std::size_t sign = word.find('@');
  const std::string what = word.substr(0, sign);
  const std::size_t colon = what.find(':');
  const std::string name = what.substr(0, colon);
  const auto kind = Kinds().find(name);
  if (kind == Kinds().end()) {
    std::vector<std::string> names;
    for (const auto& [known, unused] : Kinds()) names.push_back(known);
    throw UsageError(fmt::format("--faults: '{}' is not known; did you mean '{}'?", name,
                                 NearestWord(name, names)));
  }
  PlannedFault fault;
  fault.kind = kind->second;
  if (NeedsJoint(fault.kind))
    fault.sensor =
        SensorOf(colon == std::string::npos ? "" : what.substr(colon + 1), word, armature);
  const char* const end = word.data() + word.size();
  const char* const begin = sign == std::string::npos ? end : word.data() + sign + 1;
  const auto [last, error] = std::from_chars(begin, end, fault.frame);
  if (error != std::errc() || last != end || fault.frame < 0)
    throw UsageError(fmt::format("--faults: '{}' needs the number of a frame, as in drop@5", word));
  return fault;
}

}  // namespace

std::vector<PlannedFault> ParseFaults(const std::string& text, const Armature& armature) {
  std::vector<PlannedFault> faults;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) faults.push_back(FaultOf(word, armature));
  return faults;
}

}  // namespace keypose::armature
