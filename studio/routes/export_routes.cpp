#include "studio/routes/export_routes.h"

#include <fmt/format.h>
#include <unistd.h>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/overview.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;

void ExportRoutes::AddTo(RouteTable& table) {
  const auto file = [this](const Question& question) { return ResultFile(question); };
  table.GetBelow("/results/", file);
  table.GetBelow("/report/", file);
  table.Get("/api/results", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return ResultsJson(now); }));
  });
  table.Post("/api/reveal", [this](const Question& question) {
    const std::string path = question.Json().at("path");
    if (!path.empty() && !StaysBelow(path)) throw UsageError("that is not below out/");
    const fs::path place = project_.folder() / "out" / path;
    if (!fs::exists(place) || pipeline::RealDisk().LeadsOutside(place, project_.folder() / "out"))
      throw UsageError(fmt::format("{} is not there", place.string()));
    const fs::path shown = fs::is_directory(place) ? place : place.parent_path();
    if (access("/usr/bin/xdg-open", X_OK) != 0)
      throw UsageError(
          fmt::format("this desktop cannot be asked to show it; it is {}", shown.string()));
    LetGo({"/usr/bin/xdg-open", shown.string()}, project_.folder());
    return JsonAnswer({{"shown", true}});
  });
}

Answer ExportRoutes::ResultFile(const Question& question) const {
  const bool report = question.path.starts_with("/report/");
  const std::string below = question.path.substr(report ? 8 : 9);
  const fs::path out = project_.folder() / (report ? "out/report" : "out"), file = out / below;
  if (!StaysBelow(below) || !fs::is_regular_file(file) ||
      pipeline::RealDisk().LeadsOutside(file, project_.folder() / "out"))
    return ErrorAnswer(404, "there is nothing at this address");
  Answer answer{200, TypeOf(file), {}, file, {}};
  if (!report) answer.download = file.filename().string();
  return answer;
}

}  // namespace keypose::studio
