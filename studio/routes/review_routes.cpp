#include "studio/routes/review_routes.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/io/meshes/mesh_io.h"
#include "core/values/errors.h"
#include "pipeline/disk/clock.h"
#include "pipeline/disk/real_disk.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/not_found.h"
#include "studio/project/reviews.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A link in a project from elsewhere may lead anywhere.
fs::path WithinCache(const SharedProject& project, const fs::path& file) {
  const fs::path cache = project.folder() / ".keypose/cache";
  if (file.empty() || pipeline::RealDisk().LeadsOutside(file, cache))
    throw NotFound("of that result this is not there");
  return file;
}

fs::path FileOf(const ResultVersion& version, const std::string& path) {
  for (const ResultFile& file : version.files)
    if (file.path == path) return file.file;
  throw NotFound("that result has no such file");
}

}  // namespace

void ReviewRoutes::AddTo(RouteTable& table) {
  AddPictures(table);
  AddWords(table);
}

bool ReviewRoutes::IsRunning() { return project_.run().running() || !project_.LockedBy().empty(); }

void ReviewRoutes::AddPictures(RouteTable& table) {
  // The path of what `choose` takes of the version that is asked for.
  const auto path_of = [this](const Question& question, const char* version, const auto& choose) {
    const bool running = IsRunning();
    return WithinCache(project_, project_.With([&](Snapshot& now) -> fs::path {
      return choose(
          ResultHistory(now, running).Version(question.Get("pose"), question.Need(version)));
    }));
  };
  const auto mesh = [](const ResultVersion& version) { return version.mesh; };
  table.Get("/api/review/mesh", [path_of, mesh](const Question& question) {
    return BytesAnswer(MeshBytes(ReadMesh(path_of(question, "version", mesh))));
  });
  table.Get("/api/review/distance", [path_of, mesh](const Question& question) {
    const fs::path of = path_of(question, "version", mesh), to = path_of(question, "to", mesh);
    return BytesAnswer(FitBytes(ReadMesh(of), ReadMesh(to)));
  });
  table.Get("/api/review/texture", [path_of](const Question& question) {
    return PictureAnswer(
        path_of(question, "version", [](const ResultVersion& version) { return version.texture; }));
  });
  table.Get("/api/review/file", [path_of](const Question& question) {
    const std::string& path = question.Need("path");
    const fs::path file = path_of(
        question, "version", [&](const ResultVersion& version) { return FileOf(version, path); });
    return Answer{200, TypeOf(file), {}, file, {}};
  });
}

void ReviewRoutes::AddWords(RouteTable& table) {
  table.Get("/api/review", [this](const Question&) {
    const bool running = IsRunning();
    project_.Forget();  // the records of runs are read anew; the plan must not be older than these
    return JsonAnswer(project_.With([&](Snapshot& now) { return ReviewsJson(now, running); }));
  });
  table.Get("/api/review/compare", [this](const Question& question) {
    const bool running = IsRunning();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      return ResultHistory(now, running)
          .CompareJson(question.Get("pose"), question.Need("before"), question.Need("after"));
    }));
  });
  table.Post("/api/review", [this](const Question& question) {
    const json body = question.Json();
    const bool running = IsRunning();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      AddReview(now, {body.at("pose"), body.at("version"), body.at("verdict"), body.at("note")},
                body.at("revision"), pipeline::RealClock().Now(), running);
      return ReviewsJson(now, running);
    }));
  });
  table.Post("/api/review/remove", [this](const Question& question) {
    const json body = question.Json();
    const bool running = IsRunning();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      RemoveReview(now, body.at("index"), body.at("revision"));
      return ReviewsJson(now, running);
    }));
  });
}

}  // namespace keypose::studio
