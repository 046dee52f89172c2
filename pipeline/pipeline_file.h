// pipeline.yaml: poses, template, timeline, options, steps; read with line numbers, checked, and
// laid over the default pipeline.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace keypose::pipeline {

/// A place in a file, for messages.
struct Where {
  std::string file;
  int line = 0;
  std::string Text() const { return file + ":" + std::to_string(line); }
};

/// One scalar of the file, as text; its type is checked by whoever knows it.
struct Setting {
  std::string text;
  Where where;
};

using OptionSettings = std::map<std::string, Setting>;  ///< option -> value

struct StepSettings {
  Where where;
  OptionSettings options;
};
using StepOptionSettings = std::map<std::string, StepSettings>;  ///< by step

/// How many instances a step has.
enum class FanOut {
  kPose,       ///< one for each pose
  kTemplate,   ///< one, on the template
  kPair,       ///< one for each pose other than the template
  kAnimation,  ///< one, when there are two poses or more
  kProject     ///< one
};

/// What goes into an input port: references, in order. The template may have others than the rest.
/// A step that is not of one pose takes such a split rule once for each key on the timeline.
struct InputRule {
  bool split = false;  ///< written as {template: ..., others: ...}
  std::vector<Setting> for_template, for_others;
  Where where;
};

/// What a step takes on a machine like that on which the figures were measured, by the photographs
/// that it goes back to. Only for the time left on a first run: later ones go by the seconds of
/// earlier ones.
struct Cost {
  double fixed = 0, photograph = 0,
         /// [s] of one core: at all; for each photograph; for each megapixel of them
      megapixel = 0;
};

/// A result that a person wants to know of when a run ends.
struct ShownSetting {
  Setting path;  ///< below out/
  std::string label;
};

struct StepRule {
  std::string name;
  Where where;
  bool enabled = true;
  std::optional<Setting> stage;  ///< program keypose-STAGE
  /// an executable of the user's own; a path relative to the project
  std::optional<Setting> program;
  std::optional<FanOut> fan_out;
  std::map<std::string, InputRule> inputs;
  OptionSettings options;
  std::map<std::string, Setting> out;  ///< output port, or PORT/FILE of a folder -> path below out/
  std::vector<ShownSetting> show;      ///< in the order of the file
  std::optional<Cost> cost;
};

struct PoseRule {
  std::string name;
  Where where;
  std::optional<Setting> photos, masks, background, landmarks, cameras;
  StepOptionSettings options;
};

struct TimelineKey {
  Setting pose;
  std::optional<double> at_s;  ///< [s]; all keys have one, or none
};

struct PipelineFile {
  std::vector<StepRule> steps;  ///< in the order of the file
  std::vector<PoseRule> poses;
  std::optional<Setting> name, template_pose;
  double fps = 24;  ///< frames per second of the animation
  std::vector<TimelineKey> timeline;
  std::string timeline_json;  ///< all that it says, checked; empty when that is no more than the
                              ///< order of poses
  StepOptionSettings options;

  const StepRule* FindStep(const std::string& step) const;
  const PoseRule* FindPose(const std::string& pose) const;

 private:
  mutable std::unordered_map<std::string, std::size_t>
      pose_index_;  ///< of the first `indexed_` poses
  mutable std::size_t indexed_ = 0;
};

/// @param file  how messages name it
/// @throws UsageError  not YAML, an unknown key (with the nearest known one), a key twice, a wrong
/// type; with file:line
PipelineFile ParsePipelineFile(const std::string& text, const std::string& file);

/// `project` over `defaults`: its steps add to, change or switch off steps of the same name; all
/// else is the project's.
PipelineFile Overlay(const PipelineFile& defaults, const PipelineFile& project);

}  // namespace keypose::pipeline
