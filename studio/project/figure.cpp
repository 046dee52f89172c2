#include "studio/project/figure.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/figure_strokes.h"
#include "core/file_names.h"
#include "core/io/files.h"
#include "pipeline/figure_setting.h"
#include "studio/project/changes.h"
#include "studio/project/failure_pictures.h"
#include "studio/project/originals.h"
#include "studio/project/photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Step;
using pipeline::StepPlan;

namespace {

/// By these words of a message the page knows that a click is asked for.
constexpr const char* kAsks = "keypose figure";

/// The photographs of a pose under the page's names, and the sizes of their pictures.
class ShownPhotographs {
 public:
  ShownPhotographs(Snapshot& snapshot, const std::string& pose)
      : snapshot_(snapshot), pose_(pose), originals_(snapshot, pose) {
    for (const json& one : PhotographsJson(snapshot, pose)) names_.push_back(one.at("name"));
  }

  json JsonOf(const FigureStroke& stroke) const {
    json one = {{"text", FigureText(stroke)},
                {"picture", stroke.picture},
                {"figure", stroke.figure},
                {"points", json::array()},
                {"gone", true}};
    const int i = IndexOfPicture(stroke, names_);
    const std::string name = i < 0 ? "" : names_[static_cast<std::size_t>(i)];
    if (i < 0 || originals_.FileOf(name).empty()) return one;
    const auto [photograph, shown] = SizesOf(name);
    one["picture"] = name;
    one["gone"] = false;
    for (const Eigen::Vector2d& point : stroke.points) {
      const Eigen::Vector2d at = InCaptured(point, photograph, shown);
      one["points"].push_back({at.x() / shown.width, at.y() / shown.height});
    }
    return one;
  }

  /// @throws UsageError  no such photograph, or a place outside of it
  FigureStroke StrokeOf(const json& one) const {
    const std::string name = one.at("picture");
    const fs::path file = originals_.FileOf(name);
    if (file.empty())
      throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose_, name));
    FigureStroke stroke;
    stroke.picture = file.lexically_relative(snapshot_.PhotoFolder(pose_)).generic_string();
    stroke.figure = one.at("figure");
    const auto [photograph, shown] = SizesOf(name);
    for (const json& point : one.at("points")) {
      const double x = point.at(0), y = point.at(1);
      if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1))
        throw UsageError(fmt::format("the place {}, {} lies outside of {}", x, y, name));
      const Eigen::Vector2d at =
          InPhotograph({x * shown.width, y * shown.height}, shown, photograph);
      // A tenth of a pixel: more nobody can mean.
      stroke.points.emplace_back(std::round(10 * at.x()) / 10, std::round(10 * at.y()) / 10);
    }
    if (stroke.points.empty()) throw UsageError("a stroke has no points");
    return stroke;
  }

 private:
  struct Sizes {
    PictureSize photograph, shown;
  };
  Sizes SizesOf(const std::string& name) const {
    const ImageInfo info = OriginalInfo(originals_.FileOf(name));
    const PictureSize photograph{info.width, info.height};
    const auto [width, height] = PhotographSize(snapshot_, pose_, name);
    return {photograph, width > 0 ? PictureSize{width, height} : photograph};
  }

  Snapshot& snapshot_;
  std::string pose_;
  Originals originals_;
  std::vector<std::string> names_;
};

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
    if (LowerExtension(result.path) == ".jpg" && fs::exists(snapshot.session().out() / result.path))
      return result.path.generic_string();
  return "";
}

json AnswerOf(Snapshot& snapshot, const Step& step, const std::vector<FigureStroke>& strokes) {
  const ShownPhotographs photographs(snapshot, step.pose);
  json list = json::array();
  for (const FigureStroke& stroke : strokes) list.push_back(photographs.JsonOf(stroke));
  return {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
          {"step", step.id},
          {"problem", ""},
          {"unclear", AskedFor(snapshot, step.pose)},
          {"sheet", SheetOf(snapshot, step)},
          {"refused", RefusedOf(snapshot, step.pose)},
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
  const ShownPhotographs photographs(snapshot, pose);
  std::vector<FigureStroke> strokes;
  for (const json& one : body.at("strokes")) {
    if (one.contains("text"))
      strokes = pipeline::WithStrokes(std::move(strokes), ParseFigureStrokes(one.at("text")));
    else
      strokes = pipeline::WithStrokes(std::move(strokes), {photographs.StrokeOf(one)});
  }
  const std::string text = ReadFile(snapshot.project() / "pipeline.yaml");
  const std::string edited = pipeline::WithFigure(snapshot.file(), text, step, strokes);
  json answer = AnswerOf(snapshot, step, strokes);
  answer["unclear"] = "";  // no step has run with it yet
  answer["revision"] = WritePipelineFile(snapshot.project(), edited, body.at("revision"));
  return answer;
}

}  // namespace keypose::studio
