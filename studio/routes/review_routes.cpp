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

void ReviewRoutes::AddTo(RouteTable& table) {
  AddPictures(table);
  AddWords(table);
}

bool ReviewRoutes::IsRunning() { return project_.run().running() || !project_.LockedBy().empty(); }

std::vector<std::string> ReviewRoutes::RunRecords() const {
  return pipeline::RealDisk().Children(project_.folder() / ".keypose/runs");
}

void ReviewRoutes::AddPictures(RouteTable& table) {
  const auto file_at = [this](const Question& question, const char* name = "at") {
    return project_.With([&](Snapshot& now) -> fs::path {
      return FileAt(now.opened_project(), question.Need(name));
    });
  };
  table.Get("/api/review/mesh", [file_at](const Question& question) {
    return BytesAnswer(MeshBytes(ReadMesh(file_at(question))));
  });
  table.Get("/api/review/distance", [file_at](const Question& question) {
    return BytesAnswer(FitBytes(ReadMesh(file_at(question)), ReadMesh(file_at(question, "to"))));
  });
  table.Get("/api/review/file", [file_at](const Question& question) {
    const fs::path file = file_at(question);
    const std::string type = TypeOf(file);
    // A page among the results of a project from elsewhere would speak in the studio's name.
    if (!type.starts_with("image/") && !type.starts_with("video/"))
      throw NotFound("only pictures and films are shown");
    return Answer{200, type, {}, file, {}};
  });
}

void ReviewRoutes::AddWords(RouteTable& table) {
  table.Get("/api/review", [this](const Question&) {
    // A plan made while a run was at work is of two runs; even of one that began and ended
    // meanwhile.
    const bool running = IsRunning();
    const auto runs = RunRecords();
    project_.Forget();  // the records of runs are read anew; the plan must not be older than these
    return JsonAnswer(project_.With([&](Snapshot& now) {
      return ReviewsJson(now, running || IsRunning() || runs != RunRecords());
    }));
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
