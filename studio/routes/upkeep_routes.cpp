#include "studio/routes/upkeep_routes.h"

#include <fmt/format.h>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/not_found.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kUpkeepSeconds = 3600;  // a cache of many gigabytes is read whole

/// The words of the command, without the project's folder; `made`: a folder that it writes.
std::vector<std::string> WordsOf(const json& body, const fs::path& packed, std::string* made) {
  const std::string what = body.at("what");
  if (what == "gc-look") return {"gc", "--dry-run"};
  if (what == "gc" || what == "verify" || what == "doctor") return {what};
  if (what == "unlock") return {what, "--force"};
  if (what == "pack") return {what, "--output=" + packed.string()};
  if (what == "pack-small") return {"pack", "--without-cache", "--output=" + packed.string()};
  if (what == "cameras") {
    const std::string to = body.at("to"), pose = body.at("pose");
    if (to != "colmap" && to != "transforms" && to != "metashape")
      throw UsageError(fmt::format("cameras are written for no '{}'", to));
    if (!IsOneName(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
    *made = fmt::format("cameras_{}_{}", pose, to);
    return {what, "--to=" + to, "--pose=" + pose, "--overwrite", "--output=" + *made};
  }
  throw UsageError(fmt::format("there is no upkeep '{}'", what));
}

}  // namespace

fs::path UpkeepRoutes::PackedFile() const {
  return project_.folder() / ".keypose/studio/packed.zip";
}

void UpkeepRoutes::AddTo(RouteTable& table) {
  table.Post("/api/upkeep", [this](const Question& question) { return Do(question); });
  table.Get("/api/upkeep/packed", [this](const Question&) {
    if (!fs::exists(PackedFile())) throw NotFound("the project is not packed yet");
    Answer answer;
    answer.file = PackedFile();
    answer.type = "application/zip";
    answer.download = project_.folder().filename().string() + ".zip";
    return answer;
  });
}

Answer UpkeepRoutes::Do(const Question& question) {
  const json body = question.Json();
  std::string made;
  std::vector<std::string> words = WordsOf(body, PackedFile(), &made);
  if (project_.run().running()) throw LockedError("a run is at work; do this when it is done");
  // `pack` does not write over a file.
  std::error_code ignored;
  if (words.front() == "pack") fs::remove(PackedFile(), ignored);
  words.insert(words.begin(), (pipeline::ProgramFolder() / "keypose").string());
  if (words[1] != "doctor") words.insert(words.end(), {"-C", project_.folder().string()});
  const ChildResult result = RunChild(words, project_.folder(), kUpkeepSeconds);
  if (result.exit_code != 0 && words[1] != "verify" && words[1] != "doctor")
    throw InputError(ErrorIn(result.output, result.exit_code));
  return JsonAnswer({{"said", result.output}, {"good", result.exit_code == 0}, {"made", made}});
}

}  // namespace keypose::studio
