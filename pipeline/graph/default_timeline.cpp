#include "pipeline/graph/default_timeline.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/graph/timeline_yaml.h"

namespace keypose::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// Whether an option of a step that is of no pose is given, also on the command line.
bool IsSaid(const PipelineFile& file, const std::vector<Override>& overrides,
            const std::string& step, const std::string& option) {
  const StepRule* rule = file.FindStep(step);
  const auto given = file.options.find(step);
  return (rule && rule->options.contains(option)) ||
         (given != file.options.end() && given->second.options.contains(option)) ||
         std::any_of(overrides.begin(), overrides.end(), [&](const Override& over) {
           return over.step == step && over.option == option;
         });
}

std::string LoopJson(const std::vector<std::string>& poses, double fps,
                     const DefaultTimeline& timeline) {
  const double period_s = timeline.hold_s + timeline.move_s;
  const auto time = [&](std::size_t key) {
    return std::round(1e6 * period_s * static_cast<double>(key)) / 1e6;
  };
  Json keys = Json::array();
  for (std::size_t i = 0; i < poses.size(); ++i)
    keys.push_back({{"pose", poses[i]},
                    {"time", time(i)},
                    {"hold", timeline.hold_s},
                    {"ease", timeline.ease}});
  keys.push_back({{"pose", poses[0]}, {"time", time(poses.size())}});
  const Json all = {{"schema", 2}, {"fps", fps}, {"loop", true}, {"keys", keys}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string TimelineUnlessSaid(const PipelineFile& file, const std::vector<Override>& overrides,
                               std::vector<std::string>* keys) {
  const auto& unsaid = file.default_timeline;
  const bool ordered = !file.timeline.empty();  // by a list of poses without times
  if (ordered || !unsaid || keys->size() < 2 ||
      IsSaid(file, overrides, unsaid->unless_step, unsaid->unless_option))
    return OrderJson(*keys, file.fps);
  std::string text = LoopJson(*keys, file.fps, *unsaid);
  keys->push_back(keys->front());
  return text;
}

}  // namespace keypose::pipeline
