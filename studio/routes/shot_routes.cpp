#include "studio/routes/shot_routes.h"

#include <fmt/format.h>

#include <chrono>
#include <string_view>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/films.h"
#include "studio/project/page_shot.h"
#include "studio/project/pose_photographs.h"
#include "studio/project/shot_clicks.h"
#include "studio/project/shot_setup.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostFrames = 1'000'000'000, kMostWidth = 100'000;
constexpr double kQuickSeconds = 30;

/// Why it failed: the last line that says something, without the names before it.
std::string FaultOf(const std::string& text) {
  constexpr std::string_view kMark = "error: ", kStage = "locate: ";
  const std::size_t end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "locate ended without a word";
  const std::size_t before = text.rfind('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  std::string line = text.substr(begin, end + 1 - begin);
  if (const std::size_t mark = line.find(kMark); mark != std::string::npos)
    line.erase(0, mark + kMark.size());
  return line.starts_with(kStage) ? line.substr(kStage.size()) : line;
}

/// Runs `keypose locate --quick`. Clicks that do not agree are no fault of the request: their words
/// come as "problem".
json QuickAnswer(WarmProgram& locate, const std::vector<std::string>& flags,
                 const QuickFiles& files) {
  const auto begin = std::chrono::steady_clock::now();
  const ChildResult result = locate.Run(flags, kQuickSeconds);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
  json answer = result.exit_code == 0 ? QuicklyLocatedJson(files) : json::object();
  answer["problem"] = result.exit_code == 0 ? "" : FaultOf(result.output);
  answer["seconds"] = passed.count();
  return answer;
}

}  // namespace

ShotRoutes::ShotRoutes(SharedProject& project)
    : PageRoutes(project),
      locate_(pipeline::ProgramFolder() / "keypose-locate", project.folder()) {}

void ShotRoutes::AddTo(RouteTable& table) {
  AddParts(table);
  AddPictures(table);
  // Other requests need not wait for it.
  table.Post("/api/shot/cut", [this](const Question& question) {
    const CutFilm cut = CutIntoPictures(project_.folder(), question.Json().at("video"));
    return JsonAnswer({{"folder", cut.folder}, {"pictures", cut.pictures}, {"fps", cut.fps}});
  });
}

void ShotRoutes::AddParts(RouteTable& table) {
  const auto whole = [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return ShotJson(now); }));
  };
  table.Get("/api/shot", whole);
  const auto change = [this, whole](void (*save)(Snapshot&, const nlohmann::json&)) {
    return [this, whole, save](const Question& question) {
      project_.With([&](Snapshot& now) {
        save(now, question.Json());
        return 0;
      });
      project_.Forget();
      return whole(question);
    };
  };
  table.Put("/api/shot", change(SaveShot));
  table.Put("/api/shot/clicks", [this, save = change(SaveClicks)](const Question& question) {
    locate_.Warm();  // outlines will be asked for
    return save(question);
  });
  table.Post(
      "/api/shot/quick", [this](const Question& question) { return Quick(question); },
      Changes::kNothing);
}

Answer ShotRoutes::Quick(const Question& question) {
  const int frame = question.Json().at("frame"), mine = quick_number_++ % kMostFrames;
  const QuickFiles files = QuickFilesOf(project_.folder(), mine);
  const auto flags =
      project_.With([&](Snapshot& now) { return QuickLocateFlags(now, frame, files); });
  json answer = QuickAnswer(locate_, flags, files);
  answer["frame"] = frame;
  answer["number"] = mine;
  return JsonAnswer(answer);
}

void ShotRoutes::AddPictures(RouteTable& table) {
  table.Get("/api/shot/frame", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFrames);
    const int width = WholeNumber(question.Get("width", "0"), 0, kMostWidth);
    const fs::path file = project_.With([&](Snapshot& now) { return FilmFrameFile(now, frame); });
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
  table.Get("/api/shot/picture", [this](const Question& question) {
    const int number = WholeNumber(question.Get("number", "0"), 0, kMostFrames);
    const int width = WholeNumber(question.Get("width", "0"), 0, kMostWidth);
    const std::string what = question.Need("what");
    const fs::path file =
        project_.With([&](Snapshot& now) { return ShotPictureFile(now, what, number); });
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
}

}  // namespace keypose::studio
