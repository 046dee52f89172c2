#include "studio/project/take_use.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/pictures/frame_folder.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"
#include "pipeline/graph/pipeline_file.h"
#include "studio/project/changes.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kUses[] = {"export", "composite"};
/// What `locate` has found in this project.
constexpr const char* kLocatedShot = "out/shot/shot.json";

std::string StepOf(const std::string& use, const BakedTake& take) { return use + "_" + take.name; }

std::string OutOf(const std::string& use, const BakedTake& take) {
  return "takes/" + take.name + (use == "composite" ? "_pictures" : "");
}

std::string FramesOf(const BakedTake& take) { return "armature/" + take.name + "/frames"; }

std::string PipelineText(const fs::path& project) {
  const fs::path file = project / "pipeline.yaml";
  return fs::exists(file) ? ReadFile(file) : "";
}

/// What a file for takes alone begins with.
constexpr const char* kFirstText =
    "# Takes of a wire puppet; see docs/pipeline.md.\n"
    "steps:\n"
    "  report: {enabled: false}  # it tells of poses, and here are none\n";

std::string LackOf(const std::string& use, const BakedTake& take) {
  if (use == "export") return "";
  std::vector<std::string> lacks;
  if (take.plate.empty()) lacks.push_back("a plate");
  if (take.shot.empty()) lacks.push_back("the plate's camera");
  return fmt::format("{}", fmt::join(lacks, ", "));
}

/// "./PATH" where it is read as YAML.
std::string Reference(const std::string& path) { return YamlScalar("./" + path); }

std::string Inputs(const std::string& use, const BakedTake& take, bool located) {
  std::string inputs = "frames: " + Reference(FramesOf(take));
  const auto add = [&](const char* port, const std::string& path) {
    if (!path.empty()) inputs += fmt::format(", {}: {}", port, Reference(path));
  };
  add("textures", take.texture);
  if (use == "export") return inputs;
  if (located && take.shot == kLocatedShot)
    inputs += ", shot: locate.shot";
  else
    add("shot", take.shot);
  add("plate", take.plate);
  add("set", take.set);
  return inputs;
}

/// The step in YAML's flow style.
std::string StepText(const fs::path& project, const std::string& use, const BakedTake& take,
                     bool located) {
  const std::string out = OutOf(use, take);
  const bool exports = use == "export";
  const auto shown = [&](const char* file, const std::string& words) {
    return fmt::format("{}: {}", YamlScalar(out + "/" + file), YamlScalar(words));
  };
  const std::string name = "the take " + take.name;
  return fmt::format(
      "{{stage: {}, for: project, inputs: {{{}}}, options: {{fps: {:g}}}, out: {{{}: {}}}, show: "
      "{{{}}}}}",
      use, Inputs(use, take, located), FrameRateOf(project / FramesOf(take)),
      exports ? "animation" : "pictures", YamlScalar(out),
      exports ? shown("character.glb", name) + ", " + shown("character.mp4", name + " as a film")
              : shown("shot.mp4", name + " over its plate"));
}

std::string WithStep(const std::string& text, const std::string& step, const std::string& value) {
  const bool has_steps = text.starts_with("steps:") || text.find("\nsteps:") != std::string::npos;
  if (has_steps) return WithValue(text, {"steps", step}, value);
  const char* gap = text.empty() || text.back() == '\n' ? "" : "\n";
  return fmt::format("{}{}steps:\n  {}: {}\n", text, gap, YamlScalar(step), value);
}

bool IsBaked(const fs::path& project, const BakedTake& take) {
  return fs::is_regular_file(project / FramesOf(take) / FrameFileName(0));
}

void RequireUsable(const fs::path& project, const std::string& use, const BakedTake& take) {
  if (!IsBaked(project, take))
    throw UsageError(fmt::format("the frames of {} are not baked yet", take.name));
  if (const std::string lack = LackOf(use, take); !lack.empty())
    throw UsageError(
        fmt::format("{} cannot be put over its plate: its files lack {}", take.name, lack));
}

}  // namespace

json TakeUseJson(const fs::path& project, const BakedTake& take) {
  const pipeline::PipelineFile file =
      pipeline::ParsePipelineFile(PipelineText(project), "pipeline.yaml");
  const bool baked = IsBaked(project, take);
  const auto written = [&](const fs::path& path) { return fs::last_write_time(project / path); };
  const bool stale = baked && written("armature/" + take.name + "/curves.json") >
                                  written(FramesOf(take) + "/" + FrameFileName(0));
  json answer = {{"revision", RevisionOf(project / "pipeline.yaml")},
                 {"baked", baked},
                 {"stale", stale},
                 {"uses", json::object()}};
  for (const char* use : kUses)
    answer["uses"][use] = {{"step", StepOf(use, take)},
                           {"out", "out/" + OutOf(use, take)},
                           {"used", file.FindStep(StepOf(use, take)) != nullptr},
                           {"lack", LackOf(use, take)}};
  return answer;
}

void SaveTakeUse(const fs::path& project, const BakedTake& take, const std::string& use, bool used,
                 const std::string& revision) {
  if (use != kUses[0] && use != kUses[1])
    throw UsageError(fmt::format("a take can be for export or composite, not for '{}'", use));
  const std::string text = PipelineText(project);
  const pipeline::PipelineFile file = pipeline::ParsePipelineFile(text, "pipeline.yaml");
  const std::string step = StepOf(use, take);
  if (used) {
    RequireUsable(project, use, take);
    const std::string value = StepText(project, use, take, file.shot.has_value());
    const std::string edited =
        Edited([&] { return WithStep(text.empty() ? kFirstText : text, step, value); });
    WritePipelineFile(project, edited, revision);
    return;
  }
  const std::string edited = Edited([&] {
    return WithoutValue(WithoutValue(text, {"options", step}), {"steps", step});
  });
  // A file that was made for takes goes with the last of them.
  if (edited == kFirstText && RevisionOf(project / "pipeline.yaml") == revision)
    fs::remove(project / "pipeline.yaml");
  else
    WritePipelineFile(project, edited, revision);
}

}  // namespace keypose::studio
