#include "pipeline/graph/pipeline_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/project/timeline_json.h"
#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/sources_yaml.h"
#include "pipeline/graph/stage_info.h"
#include "pipeline/graph/timeline_yaml.h"
#include "pipeline/graph/yaml_reader.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

std::string JsonText(const std::string& text) { return nlohmann::json(text).dump(); }

/// Reads the tree of a pipeline file.
class Reader : public YamlReader {
 public:
  using YamlReader::YamlReader;

  OptionSettings Options(const YAML::Node& node, const std::string& what) const {
    OptionSettings options;
    Map(node, what, [&](const std::string& key, const YAML::Node&, const YAML::Node& value) {
      options[key] = Text(value, what + "." + key);
    });
    return options;
  }

  StepOptionSettings StepOptions(const YAML::Node& node, const std::string& what) const {
    StepOptionSettings options;
    Map(node, what, [&](const std::string& step, const YAML::Node& key, const YAML::Node& value) {
      options[step] = {At(key), Options(value, what + "." + step)};
    });
    return options;
  }

  PoseRule Pose(const std::string& name, const YAML::Node& key, const YAML::Node& node) const {
    CheckName(key, "the pose name");
    PoseRule pose;
    pose.name = name;
    pose.where = At(key);
    if (node.IsScalar()) {
      pose.given.push_back(ReadGiven(*this, kPhotosWord, node, node));
      return pose;
    }
    const std::string what = "pose '" + name + "'";
    Map(node, what,
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "method")
            pose.method = Choice(value, field, {"scan", "fit"});
          else if (field == "options")
            pose.options = StepOptions(value, what + ".options");
          else
            pose.given.push_back(ReadGiven(*this, field, field_key, value));
        });
    return pose;
  }

  PoseRule Shot(const std::string& name, const YAML::Node& key, const YAML::Node& node) const {
    CheckName(key, "the shot name");
    PoseRule shot;
    shot.name = name;
    shot.where = At(key);
    if (node.IsScalar()) {
      shot.given.push_back(ReadGiven(*this, kVideoWord, node, node));
      return shot;
    }
    const std::string what = "shot '" + name + "'";
    Map(node, what,
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "options")
            shot.options = StepOptions(value, what + ".options");
          else
            shot.given.push_back(ReadGiven(*this, field, field_key, value));
        });
    return shot;
  }

  double Fps(const YAML::Node& node) const {
    const double fps = Number(node, "fps");
    if (fps <= 0 || fps > 1000)
      Fail(node, fmt::format("fps is {}, but it must be more than 0 and at most 1000", fps));
    return fps;
  }

  /// The name of a pose in normal form (NFC), in which all pose names are compared.
  Setting PoseName(const YAML::Node& node, const std::string& what) const {
    Setting setting = Text(node, what);
    setting.text = Composed(setting.text);
    return setting;
  }

  /// Pose and time. The other fields are for readers of the timeline; CheckTimeline checks them.
  TimelineKey Key(const YAML::Node& node) const {
    if (node.IsScalar()) return {PoseName(node, "timeline"), std::nullopt};
    TimelineKey key;
    Map(node, "a timeline key",
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "pose")
            key.pose = PoseName(value, "timeline pose");
          else if (field == "at")
            key.at_s = Number(value, "timeline 'at'");
          else if (field == "time")
            Unknown(field_key, "a timeline key", {"at"});
        });
    if (key.pose.text.empty())
      Fail(node, "a timeline key needs a pose, as in `{pose: rest, at: 0}`");
    return key;
  }

  /// The list of keys of a timeline in either of its two forms.
  YAML::Node KeyList(const YAML::Node& node) const {
    if (!node.IsMap()) return node;
    YAML::Node keys;
    Map(node, "the timeline",
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "keys") keys.reset(value);
          if (field == "fps" || field == "schema")
            Fail(field_key, fmt::format("`{}` does not belong to the timeline", field));
        });
    if (!keys.IsDefined() || keys.IsNull()) Fail(node, "the timeline has no list `keys`");
    return keys;
  }

  std::vector<TimelineKey> Timeline(const YAML::Node& node) const {
    const YAML::Node list = KeyList(node);
    if (!list.IsSequence())
      Fail(list, "timeline must be a list of poses, as in `[rest, bent, rest]`");
    if (list.size() < 2) Fail(list, "a timeline needs two keys or more");
    std::vector<TimelineKey> keys;
    for (const YAML::Node& item : list) {
      keys.push_back(Key(item));
      const TimelineKey* before = keys.size() > 1 ? &keys[keys.size() - 2] : nullptr;
      if (before && before->at_s.has_value() != keys.back().at_s.has_value())
        Fail(item, "either all timeline keys have an 'at', or none");
      if (before && before->at_s && *before->at_s >= *keys.back().at_s)
        Fail(item, "timeline keys must come in the order of time, each later than the one before");
    }
    return keys;
  }

  DefaultTimeline TimelineUnlessSaid(const YAML::Node& node) const {
    DefaultTimeline timeline;
    const auto seconds = [&](const YAML::Node& value, const std::string& field, double least) {
      const double number = Number(value, field);
      if (!(number >= least && number <= 3600))
        Fail(value, fmt::format("{} must be from {:g} to 3600 seconds", field, least));
      return number;
    };
    Map(node, "default_timeline",
        [&](const std::string& field, const YAML::Node& key, const YAML::Node& value) {
          if (field == "hold") {
            timeline.hold_s = seconds(value, field, 0);
          } else if (field == "move") {
            timeline.move_s = seconds(value, field, 0.1);
          } else if (field == "ease") {
            timeline.ease = Text(value, field).text;
            if (!EaseNamed(timeline.ease))
              Fail(value, "ease must be linear, ease, in, out or in-out");
          } else if (field == "unless") {
            const std::string option = Text(value, field).text;
            const auto dot = option.find('.');
            if (dot == std::string::npos) Fail(value, "unless must be STEP.OPTION");
            timeline.unless_step = option.substr(0, dot);
            timeline.unless_option = option.substr(dot + 1);
          } else {
            Unknown(key, "default_timeline", {"hold", "move", "ease", "unless"});
          }
        });
    return timeline;
  }

  /// The whole timeline is checked before any step runs.
  std::string CheckedTimeline(const YAML::Node& node, double fps) const {
    std::string text = TimelineJson(node, fps);
    if (text.empty()) return text;
    try {
      ParseTimeline(text, "timeline");
    } catch (const TimelineError& error) {
      const YAML::Node list = KeyList(node);
      Fail(error.key >= 0 ? list[error.key] : node, error.what());
    }
    return text;
  }

  std::vector<Setting> References(const YAML::Node& node, const std::string& what) const {
    if (node.IsNull()) return {};
    if (!node.IsSequence()) return {PathText(node, what)};
    std::vector<Setting> references;
    for (const YAML::Node& item : node) references.push_back(PathText(item, what));
    return references;
  }

  InputRule Either(const YAML::Node& node, const std::string& what) const {
    InputRule rule;
    rule.where = At(node);
    rule.either = true;
    Map(node, what, [&](const std::string& field, const YAML::Node& key, const YAML::Node& value) {
      if (field != "either") Fail(key, fmt::format("{} has `either`, and nothing beside it", what));
      rule.for_template = rule.for_others = References(value, what);
    });
    return rule;
  }

  InputRule Input(const YAML::Node& node, const std::string& what) const {
    InputRule rule;
    rule.where = At(node);
    if (!node.IsMap()) {
      rule.for_template = rule.for_others = References(node, what);
      return rule;
    }
    if (node["either"]) return Either(node, what);
    rule.split = true;
    Map(node, what, [&](const std::string& field, const YAML::Node& key, const YAML::Node& value) {
      if (field == "template")
        rule.for_template = References(value, what);
      else if (field == "others")
        rule.for_others = References(value, what);
      else if (field == "fit")
        rule.for_fit = References(value, what);
      else
        Unknown(key, what, {"template", "others", "fit", "either"});
    });
    return rule;
  }

  FanOut Fan(const YAML::Node& node) const {
    static const std::map<std::string, FanOut> kKinds = {
        {"pose", FanOut::kPose},           {"template", FanOut::kTemplate},
        {"shot", FanOut::kPose},           {"pair", FanOut::kPair},
        {"character", FanOut::kCharacter}, {"animation", FanOut::kAnimation},
        {"project", FanOut::kProject}};
    return kKinds.at(
        Choice(node, "for",
               {"pose", "shot", "template", "pair", "character", "animation", "project"})
            .text);
  }

  StepMethod MethodOf(const YAML::Node& node) const {
    const std::string text = Choice(node, "method", {"any", "scan", "fit"}).text;
    if (text == "scan") return StepMethod::kScan;
    return text == "fit" ? StepMethod::kFit : StepMethod::kAny;
  }

  std::vector<ShownSetting> Shown(const YAML::Node& node, const std::string& what) const {
    std::vector<ShownSetting> shown;
    Map(node, what, [&](const std::string& path, const YAML::Node& key, const YAML::Node& value) {
      shown.push_back({{path, At(key)}, Text(value, what + "." + path).text});
    });
    return shown;
  }

  Cost CostOf(const YAML::Node& node, const std::string& what) const {
    Cost cost;
    const std::map<std::string, double*> fields = {
        {"fixed", &cost.fixed}, {"photograph", &cost.photograph}, {"megapixel", &cost.megapixel}};
    Map(node, what, [&](const std::string& field, const YAML::Node& key, const YAML::Node& value) {
      const auto it = fields.find(field);
      if (it == fields.end()) Unknown(key, what, {"fixed", "photograph", "megapixel"});
      *it->second = Number(value, what + "." + field);
      if (*it->second < 0)
        Fail(value,
             fmt::format("{}.{} is {}, but it must not be negative", what, field, *it->second));
    });
    return cost;
  }

  void StepOptionsOf(const YAML::Node& node, const std::string& what, StepRule& step) const {
    Map(node, what, [&](const std::string& name, const YAML::Node&, const YAML::Node& value) {
      const std::string option = what + "." + name;
      if (!value.IsMap()) {
        step.options[name] = Text(value, option);
        return;
      }
      Map(value, option,
          [&](const std::string& method, const YAML::Node& key, const YAML::Node& of_method) {
            if (method == "scan")
              step.scan_options[name] = Text(of_method, option);
            else if (method == "fit")
              step.fit_options[name] = Text(of_method, option);
            else
              Unknown(key, option, {"scan", "fit"});
          });
    });
  }

  StepRule Step(const std::string& name, const YAML::Node& key, const YAML::Node& node) const {
    CheckName(key, "the step name");
    StepRule step;
    step.name = name;
    step.where = At(key);
    const std::string what = "step '" + name + "'";
    Map(node, what,
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "stage")
            step.stage = Text(value, field);
          else if (field == "program")
            step.program = PathText(value, field);
          else if (field == "for")
            step.fan_out = Fan(value);
          else if (field == "method")
            step.method = MethodOf(value);
          else if (field == "when")
            step.when = References(value, what + ".when");
          else if (field == "enabled")
            step.enabled = Bool(value, what + ".enabled");
          else if (field == "options")
            StepOptionsOf(value, what + ".options", step);
          else if (field == "inputs")
            Map(value, what + ".inputs",
                [&](const std::string& port, const YAML::Node&, const YAML::Node& input) {
                  step.inputs[port] = Input(input, what + ".inputs." + port);
                });
          else if (field == "out")
            step.out = Options(value, what + ".out");
          else if (field == "show")
            step.show = Shown(value, what + ".show");
          else if (field == "cost")
            step.cost = CostOf(value, what + ".cost");
          else
            Unknown(field_key, what,
                    {"stage", "program", "for", "method", "when", "enabled", "inputs", "options",
                     "out", "show", "cost"});
        });
    return step;
  }

  /// The map `poses` or `shots`.
  void Poses(const std::string& field, const YAML::Node& node, PipelineFile& file) const {
    const bool shots = field == "shots";
    Map(node, field, [&](const std::string& name, const YAML::Node& key, const YAML::Node& value) {
      const std::string composed = Composed(name);
      file.poses.push_back(shots ? Shot(composed, key, value) : Pose(composed, key, value));
      if (file.FindPose(composed) != &file.poses.back())
        Fail(key, fmt::format("{} has the {} '{}' twice", field, shots ? "shot" : "pose", name));
    });
  }

  int FrameNumber(const YAML::Node& node) const {
    const double number = Number(node, "a frame of `shows`");
    if (number < 0 || number > 1e6 || number != std::floor(number))
      Fail(node,
           "`shows` names frames by their numbers, counted from the film's first picture, as "
           "in {0: rest, 4: wave}");
    return static_cast<int>(number);
  }

  std::vector<ShotRule::Shows> Shows(const YAML::Node& node) const {
    std::map<int, ShotRule::Shows> shows;
    Map(node, "shows", [&](const std::string&, const YAML::Node& key, const YAML::Node& value) {
      const int frame = FrameNumber(key);
      if (!shows.emplace(frame, ShotRule::Shows{frame, PoseName(value, "shows")}).second)
        Fail(key, fmt::format("shows has frame {} twice", frame));
    });
    std::vector<ShotRule::Shows> sorted;
    for (const auto& [frame, show] : shows) sorted.push_back(show);
    return sorted;
  }

  ShotRule FilmedShot(const YAML::Node& key, const YAML::Node& node) const {
    ShotRule shot;
    shot.where = At(key);
    Map(node, "shot",
        [&](const std::string& field, const YAML::Node& field_key, const YAML::Node& value) {
          if (field == "fps")
            shot.fps = Fps(value);
          else if (field == "shows")
            shot.shows = Shows(value);
          else
            shot.given.push_back(ReadGiven(*this, field, field_key, value));
        });
    return shot;
  }

  /// The shown poses at the times of their frames; straight from one to the next.
  void TimelineOfShot(const YAML::Node& node, PipelineFile* file) const {
    const ShotRule& shot = *file->shot;
    if (shot.shows.empty()) return;  // CheckShownFrames names it
    const double ratio = file->fps / shot.fps;
    if (std::abs(ratio - std::round(ratio)) > 1e-6 || ratio < 0.5)
      Fail(node, fmt::format("the project's fps is {:g}, and the film's {:g}: the first must be a "
                             "multiple of the second, such as 24 of 12",
                             file->fps, shot.fps));
    if (!file->timeline.empty()) return;
    std::string keys;
    for (const ShotRule::Shows& show : shot.shows) {
      const double seconds = (show.frame - shot.shows.front().frame) / shot.fps;
      file->timeline.push_back({show.pose, seconds});
      keys += fmt::format("{}{{\"pose\": {}, \"time\": {:.9g}}}", keys.empty() ? "" : ", ",
                          JsonText(show.pose.text), seconds);
    }
    file->timeline_json = fmt::format(
        "{{\"schema\": 2, \"fps\": {:.9g}, \"interpolation\": \"linear\", \"keys\": [{}]}}",
        file->fps, keys);
  }

  /// Keys that mean nothing in a project of this kind.
  void RequireKeysOfKind(const YAML::Node& root, ProjectKind kind) const {
    if (!root.IsMap()) return;
    const bool performance = kind == ProjectKind::kPerformance;
    const std::set<std::string> others =
        performance ? std::set<std::string>{"poses", "template", "timeline", "shot"}
                    : std::set<std::string>{"shots"};
    for (const auto& pair : root) {
      const std::string key = pair.first.Scalar();
      if (others.contains(key)) Fail(pair.first, OfOtherKind(key, kind));
    }
  }

  ProjectKind Kind(const YAML::Node& node) const {
    const std::string text = Choice(node, "kind", {"poses", "performance"}).text;
    return text == "performance" ? ProjectKind::kPerformance : ProjectKind::kPoses;
  }

  PipelineFile File(const YAML::Node& root) const {
    PipelineFile file;
    YAML::Node timeline, shot;
    Map(root, "the pipeline",
        [&](const std::string& field, const YAML::Node& key, const YAML::Node& value) {
          if (field == "name")
            file.name = Text(value, field);
          else if (field == "kind")
            file.kind = Kind(value);
          else if (field == "sources")
            file.sources = ReadSources(*this, value);
          else if (field == "shot") {
            file.shot = FilmedShot(key, value);
            shot.reset(key);
          } else if (field == "template")
            file.template_pose = PoseName(value, field);
          else if (field == "timeline") {
            file.timeline = Timeline(value);
            timeline.reset(value);
          } else if (field == "default_timeline")
            file.default_timeline = TimelineUnlessSaid(value);
          else if (field == "fps")
            file.fps = Fps(value);
          else if (field == "options")
            file.options = StepOptions(value, "options");
          else if (field == "poses" || field == "shots")
            Poses(field, value, file);
          else if (field == "steps")
            Map(value, "steps",
                [&](const std::string& name, const YAML::Node& step_key, const YAML::Node& step) {
                  file.steps.push_back(Step(name, step_key, step));
                });
          else
            file.given.push_back(ReadGiven(*this, field, key, value));
        });
    RequireKeysOfKind(root, file.kind);
    if (!file.timeline.empty()) file.timeline_json = CheckedTimeline(timeline, file.fps);
    if (file.shot) TimelineOfShot(shot, &file);
    return file;
  }
};

}  // namespace

std::string NameOf(ProjectKind kind) {
  return kind == ProjectKind::kPerformance ? "performance" : "poses";
}

std::string OfOtherKind(const std::string& key, ProjectKind kind) {
  return fmt::format("`{}` belongs to a project of {}", key,
                     kind == ProjectKind::kPerformance ? "poses; this one has `kind: performance`"
                                                       : "a performance; add `kind: performance`");
}

const StepRule* PipelineFile::FindStep(const std::string& step) const {
  const auto it = std::find_if(steps.begin(), steps.end(),
                               [&](const StepRule& rule) { return rule.name == step; });
  return it == steps.end() ? nullptr : &*it;
}

const PoseRule* PipelineFile::FindPose(const std::string& pose) const {
  for (; indexed_ < poses.size(); ++indexed_) pose_index_.emplace(poses[indexed_].name, indexed_);
  const auto it = pose_index_.find(pose);
  return it == pose_index_.end() ? nullptr : &poses[it->second];
}

PipelineFile ParsePipelineFile(const std::string& text, const std::string& file) {
  try {
    return Reader(file).File(LoadYaml(text, file));
  } catch (const YAML::Exception& error) {
    throw UsageError(
        fmt::format("{}:{}: this is not YAML: {}", file, error.mark.line + 1, error.msg));
  }
}

}  // namespace keypose::pipeline
