#include "pipeline/graph/figure_setting.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"
#include "pipeline/graph/pipeline_edit.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

bool IsPerformance(const Graph& graph) { return graph.kind == ProjectKind::kPerformance; }

const Step* StepOfStage(const Graph& graph, const std::string& stage, const std::string& pose) {
  for (const Step& step : graph.steps)
    if (step.pose == pose && step.info->stage == stage) return &step;
  return nullptr;
}

/// Why nothing of a pose or shot can be told what the figure is.
[[noreturn]] void NoStep(const Graph& graph, const std::string& pose) {
  if (IsPerformance(graph))
    throw UsageError(fmt::format(
        "nothing makes masks of shot '{0}': a folder masks beside its films gives them, which need "
        "no click (or the step silhouettes is switched off)",
        pose));
  throw UsageError(fmt::format(
      "nothing makes masks of pose '{}': it is a mesh that was made elsewhere, or its steps masks "
      "and capture are switched off",
      pose));
}

bool operator==(const FigureStroke& a, const FigureStroke& b) {
  return a.picture == b.picture && a.points == b.points && a.figure == b.figure;
}

/// How well a photograph's path answers to what was typed: 0 not at all.
int MatchOf(const std::string& on_disk, const std::string& typed) {
  const std::string file = Composed(on_disk);
  if (file == typed) return 4;
  if (fs::path(file).filename() == typed) return 3;
  std::string joined = file;
  std::replace(joined.begin(), joined.end(), '/', '_');
  const fs::path parent = fs::path(file).parent_path();
  const std::string written = WrittenName(file);
  if (joined == typed || (!parent.empty() && parent.filename().string() + "_" + written == typed))
    return 2;
  return written == typed ? 1 : 0;
}

}  // namespace

const Step& FigureStep(const Graph& graph, const std::string& pose) {
  if (std::find(graph.poses.begin(), graph.poses.end(), pose) == graph.poses.end())
    throw UsageError(fmt::format("the project has no {} '{}'{}",
                                 IsPerformance(graph) ? "shot" : "pose", pose,
                                 Suggestion(pose, graph.poses)));
  const std::vector<std::string> stages = IsPerformance(graph)
                                              ? std::vector<std::string>{"silhouettes"}
                                              : std::vector<std::string>{"masks", "capture"};
  for (const std::string& stage : stages) {
    const Step* step = StepOfStage(graph, stage, pose);
    if (step == nullptr) continue;
    OptionOf(*step->info, kFigureOption);
    return *step;
  }
  NoStep(graph, pose);
}

std::vector<FigureStroke> FigureStrokesOf(const Step& step) {
  try {
    return ParseFigureStrokes(step.options.at(kFigureOption));
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("pipeline.yaml, step '{}': {}", step.id, error.what()));
  }
}

std::string WithFigure(const PipelineFile& file, const std::string& text, const Step& step,
                       const std::vector<FigureStroke>& strokes) {
  const YamlPath below = {"options", step.rule, kFigureOption};
  const auto for_all = file.options.find(step.rule);
  const bool stays_for_all =
      for_all != file.options.end() && for_all->second.options.contains(kFigureOption);
  return Edited([&] {
    if (strokes.empty() && !stays_for_all) return WithoutPoseSetting(file, text, step.pose, below);
    return WithPoseSetting(file, text, step.pose, below, YamlScalar(FigureText(strokes)));
  });
}

std::string PhotographMeant(const std::vector<std::string>& files, const std::string& typed) {
  int best = 0;
  std::vector<std::string> found;
  for (const std::string& file : files) {
    const int match = MatchOf(file, Composed(typed));
    if (match > best) {
      best = match;
      found.clear();
    }
    if (match > 0 && match == best) found.push_back(file);
  }
  if (found.empty())
    throw UsageError(fmt::format("there is no photograph '{}'{}", typed, Suggestion(typed, files)));
  if (found.size() > 1)
    throw UsageError(fmt::format("there are {} photographs '{}': {}; name one with its folder",
                                 found.size(), typed, fmt::join(found, ", ")));
  return found.front();
}

void RequireWithin(const FigureStroke& stroke, PictureSize size) {
  for (const Eigen::Vector2d& point : stroke.points)
    if (!(point.x() <= size.width && point.y() <= size.height))
      throw UsageError(fmt::format(
          "the place {},{} lies outside of {}, which has {} x {} pixels as a viewer shows it; x "
          "runs to the right and y down, from the upper left corner",
          point.x(), point.y(), stroke.picture, size.width, size.height));
}

void RequireNoContradiction(const std::vector<FigureStroke>& strokes) {
  for (const FigureStroke& one : strokes)
    for (const FigureStroke& other : strokes)
      if (one.figure && !other.figure && one.picture == other.picture && one.points == other.points)
        throw UsageError(fmt::format(
            "{}:{},{} is said both to be the figure and not to be it; take back what is wrong with "
            "--clear, and say the rest again",
            one.picture, one.points.front().x(), one.points.front().y()));
}

std::vector<FigureStroke> WithStrokes(std::vector<FigureStroke> strokes,
                                      const std::vector<FigureStroke>& more) {
  for (const FigureStroke& stroke : more)
    if (std::none_of(strokes.begin(), strokes.end(),
                     [&](const FigureStroke& one) { return one == stroke; }))
      strokes.push_back(stroke);
  return strokes;
}

std::vector<const Step*> StepsThatFollow(const Graph& graph, const Step& step) {
  std::vector<char> after(graph.steps.size(), 0);
  const auto start = static_cast<std::size_t>(&step - graph.steps.data());
  std::vector<const Step*> following;
  // Each step stands after all that it needs.
  for (std::size_t i = start + 1; i < graph.steps.size(); ++i) {
    after[i] = std::any_of(graph.steps[i].needs.begin(), graph.steps[i].needs.end(), [&](int need) {
      const auto k = static_cast<std::size_t>(need);
      return k == start || after[k];
    });
    if (after[i]) following.push_back(&graph.steps[i]);
  }
  return following;
}

}  // namespace keypose::pipeline
