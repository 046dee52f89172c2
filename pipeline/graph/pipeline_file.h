// pipeline.yaml: poses, template, timeline, options, steps. It is read with line numbers, checked,
// and merged over the default pipeline.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "pipeline/graph/source_rule.h"
#include "pipeline/text/setting.h"

namespace keypose::pipeline {

using OptionSettings = std::map<std::string, Setting>;  ///< option -> value

struct StepSettings {
  Where where;
  OptionSettings options;
};
using StepOptionSettings = std::map<std::string, StepSettings>;  ///< by step

/// How many instances a step has.
enum class FanOut {
  kPose,       ///< one for each pose, or for each shot
  kTemplate,   ///< one, on the template
  kPair,       ///< one for each pose other than the template
  kCharacter,  ///< one, when there is a pose
  kAnimation,  ///< one, when there are two poses or more
  kProject     ///< one
};

/// What a project makes.
enum class ProjectKind {
  kPoses,       ///< key poses from photographs, and frames between them
  kPerformance  ///< a scan that moves as an actor in films; its shots stand where poses stand
};
/// As in `kind:`.
std::string NameOf(ProjectKind kind);
/// What is said of a key that belongs to projects of the other kind.
std::string OfOtherKind(const std::string& key, ProjectKind kind);

/// How a pose's shape is found.
enum class Method {
  kScan,  ///< from photographs all round: 16 or more
  kFit    ///< by bending the template until it agrees with a few photographs
};

/// Which poses a step of poses or pairs has instances for.
enum class StepMethod { kAny, kScan, kFit };

/// The references for an input port, in order. The template may have other references than the
/// other poses, and those of few photographs again others (a split rule). A step that is not of a
/// single pose applies a split rule once per key of the timeline.
struct InputRule {
  bool split = false;  ///< written as {template: ..., others: ..., fit: ...}
  std::vector<Setting> for_template, for_others;
  std::optional<std::vector<Setting>> for_fit;  ///< none: as for_others
  /// written as {either: [...]}: only the first whose step exists counts
  bool either = false;
  Where where;
};

/// The time of a step on the machine where the figures were measured, depending on the photographs
/// that it derives from. Used only for the time left on a first run; later runs use measured
/// seconds.
struct Cost {
  /// [s] on one core: constant; per photograph; per megapixel of the photographs
  double fixed = 0, photograph = 0, megapixel = 0;
};

/// A result that is shown at the end of a run.
struct ShownSetting {
  Setting path;  ///< below out/
  std::string label;
};

struct StepRule {
  std::string name;
  Where where;
  bool enabled = true;
  std::optional<Setting> stage;  ///< program keypose-STAGE
  /// an executable of the user, relative to the project
  std::optional<Setting> program;
  std::optional<FanOut> fan_out;
  std::optional<StepMethod> method;  ///< none: any
  std::vector<Setting> when;  ///< words: the step exists only where the project gives all of them
  std::map<std::string, InputRule> inputs;
  /// for all poses; for poses of one method, written as OPTION: {scan: ..., fit: ...}
  OptionSettings options, scan_options, fit_options;
  std::map<std::string, Setting> out;  ///< output port, or PORT/FILE of a folder -> path below out/
  std::vector<ShownSetting> show;      ///< in the order of the file
  std::optional<Cost> cost;
};

/// A pose, or a shot of a performance.
struct PoseRule : GivesSources {
  std::string name;
  Where where;
  std::optional<Setting> method;  ///< "scan" or "fit"
  StepOptionSettings options;

  Method FoundBy() const { return method && method->text == "fit" ? Method::kFit : Method::kScan; }
};

struct TimelineKey {
  Setting pose;
  std::optional<double> at_s;  ///< [s]; set for all keys or for none
};

/// What plays where a project has no timeline: each pose is held and moves on to the next one, the
/// last back to the first.
struct DefaultTimeline {
  double hold_s = 0, move_s = 1;
  std::string ease = "linear";  ///< as a key's
  /// where the project says this option, it has only the poses' order; empty: nowhere
  std::string unless_step, unless_option;
};

/// A filmed shot that the in-betweens go into. It gives a `film`: a folder of numbered pictures, or
/// a video.
struct ShotRule : GivesSources {
  Where where;
  double fps = 12;  ///< of the film
  struct Shows {
    int frame = 0;  ///< counts from the film's first picture
    Setting pose;
  };
  std::vector<Shows> shows;  ///< which frames show a pose, ascending
};

struct PipelineFile : GivesSources {
  std::vector<SourceRule> sources;  ///< in the order of the file
  std::vector<StepRule> steps;      ///< in the order of the file
  ProjectKind kind = ProjectKind::kPoses;
  std::vector<PoseRule> poses;
  std::optional<ShotRule> shot;  ///< of poses: what they were filmed in
  std::optional<Setting> name, template_pose;
  double fps = 24;  ///< frames per second of the animation
  std::vector<TimelineKey> timeline;
  /// the whole timeline, checked; empty if it only gives the order of poses. With a shot and no
  /// timeline: the shown poses at their frames' times
  std::string timeline_json;
  std::optional<DefaultTimeline> default_timeline;
  StepOptionSettings options;

  const StepRule* FindStep(const std::string& step) const;
  const PoseRule* FindPose(const std::string& pose) const;

 private:
  mutable std::unordered_map<std::string, std::size_t>
      pose_index_;  ///< of the first `indexed_` poses
  mutable std::size_t indexed_ = 0;
};

/// Keys of poses, shots and the project that may be words of the table `sources` are kept as given:
/// the table may stand in the default pipeline. CheckSources checks them.
///
/// @param file  the name of the file in messages
/// @throws UsageError  not YAML, an unknown key (names the nearest known one), a duplicate key, a
/// wrong type; with file:line
PipelineFile ParsePipelineFile(const std::string& text, const std::string& file);

}  // namespace keypose::pipeline
