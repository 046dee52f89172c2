#include "studio/project/figure.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/figure_strokes.h"
#include "core/values/file_names.h"
#include "pipeline/graph/figure_setting.h"
#include "studio/project/changes.h"
#include "studio/project/failure_pictures.h"
#include "studio/project/figure_pictures.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Step;
using pipeline::StepPlan;

namespace {

/// By these words of a message the page knows that a click is asked for.
constexpr const char* kAsks = "keypose figure";

json ReportOf(const StepPlan& planned) {
  const fs::path file = planned.artifact ? planned.artifact->folder / "report.json" : fs::path();
  if (file.empty() || !fs::is_regular_file(file)) return json::object();
  const json report = json::parse(ReadFile(file), nullptr, false);
  return report.is_object() ? report : json::object();
}

/// What a program said when it failed, without its name before.
std::string Words(const std::string& said) {
  constexpr const char* kMark = ": error: ";
  const auto mark = said.find(kMark);
  return mark == said.npos ? said : said.substr(mark + std::strlen(kMark));
}

/// What a step says that asks for a click; "" if it does not.
std::string AskedBy(const StepPlan& planned) {
  const auto asks = [](const std::string& text) { return text.find(kAsks) != text.npos; };
  const auto& last = planned.last;
  if (last && last->failed && last->failed_fingerprint == planned.fingerprint)
    return asks(last->error) ? WithoutPicturePaths(Words(last->error)) : "";
  if (planned.state != StepPlan::State::kDone) return "";
  const json report = ReportOf(planned);
  for (const json& warning : report.value("warnings", json::array()))
    if (warning.is_string() && asks(warning)) return warning;
  const json measured = report.value("measurements", json::object());
  const bool unclear = measured.is_object() && measured.value("figure_unclear", json()) == true;
  return unclear ? "the photographs do not tell what the figure is" : "";
}

std::string AskedFor(Snapshot& snapshot, const std::string& pose) {
  const auto& steps = snapshot.graph().steps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].pose != pose) continue;
    if (std::string words = AskedBy(snapshot.plan()[static_cast<int>(i)]); !words.empty())
      return words;
  }
  return "";
}

/// What the steps of a pose took for the figure when they last refused it: as FailurePicturesJson.
/// It stays while a person says what the figure is, until such a step succeeds.
json RefusedOf(Snapshot& snapshot, const std::string& pose) {
  json refused = json::array();
  const auto& steps = snapshot.graph().steps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& last = snapshot.plan()[static_cast<int>(i)].last;
    if (steps[i].pose != pose || !last || last->error.find(kAsks) == std::string::npos) continue;
    for (const json& picture : FailurePicturesJson(snapshot, steps[i])) refused.push_back(picture);
  }
  return refused;
}

/// The picture of all masks among what is published of a step.
std::string SheetOf(Snapshot& snapshot, const Step& step) {
  for (const pipeline::NamedResult& result : step.results)
    if (LowerExtension(result.path) == ".jpg" &&
        fs::exists(snapshot.opened_project().out() / result.path))
      return result.path.generic_string();
  return "";
}

json AnswerOf(Snapshot& snapshot, const Step& step, const std::vector<FigureStroke>& strokes) {
  const auto pictures = PicturesOfFigure(snapshot, step.pose);
  json list = json::array(), follow = json::array();
  for (const FigureStroke& stroke : strokes) list.push_back(pictures->JsonOf(stroke));
  for (const Step* after : pipeline::StepsThatFollow(snapshot.graph(), step))
    follow.push_back(after->id);
  return {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
          {"step", step.id},
          {"problem", ""},
          {"unclear", AskedFor(snapshot, step.pose)},
          {"sheet", SheetOf(snapshot, step)},
          {"refused", RefusedOf(snapshot, step.pose)},
          {"follow", follow},
          {"strokes", list}};
}

}  // namespace

json FigureJson(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  json none = {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
               {"step", ""},
               {"unclear", ""},
               {"sheet", ""},
               {"refused", json::array()},
               {"follow", json::array()},
               {"strokes", json::array()}};
  try {
    const Step& step = pipeline::FigureStep(snapshot.graph(), pose);
    none["step"] = step.id;
    return AnswerOf(snapshot, step, pipeline::FigureStrokesOf(step));
  } catch (const UsageError& error) {
    none["problem"] = error.what();
  }
  return none;
}

json SaveFigure(Snapshot& snapshot, const std::string& pose, const json& body) {
  const Step& step = pipeline::FigureStep(snapshot.graph(), pose);
  const auto pictures = PicturesOfFigure(snapshot, pose);
  std::vector<FigureStroke> strokes;
  for (const json& one : body.at("strokes")) {
    if (one.contains("text"))
      strokes = pipeline::WithStrokes(std::move(strokes), ParseFigureStrokes(one.at("text")));
    else
      strokes = pipeline::WithStrokes(std::move(strokes), {pictures->StrokeOf(one)});
  }
  const std::string text = ReadFile(snapshot.project() / "pipeline.yaml");
  const std::string edited = pipeline::WithFigure(snapshot.file(), text, step, strokes);
  json answer = AnswerOf(snapshot, step, strokes);
  answer["unclear"] = "";  // no step has run with it yet
  answer["revision"] = WritePipelineFile(snapshot.project(), edited, body.at("revision"));
  return answer;
}

}  // namespace keypose::studio
