#include "studio/routes/mending_routes.h"

#include "core/io/meshes/mesh_io.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/mending.h"

namespace keypose::studio {

namespace fs = std::filesystem;

void MendingRoutes::AddTo(RouteTable& table) {
  table.Get("/api/mending", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return MendingJson(now, question.Need("pose")); }));
  });
  table.Put("/api/mending", [this](const Question& question) {
    return JsonAnswer(project_.With(
        [&](Snapshot& now) { return SaveMending(now, question.Need("pose"), question.Json()); }));
  });
  table.Get("/api/mending/mesh", [this](const Question& question) {
    const fs::path path =
        project_.With([&](Snapshot& now) { return MeshToMend(now, question.Need("pose")); });
    return BytesAnswer(MeshBytes(ReadMesh(path)));
  });
  table.Post(
      "/api/mending/draft",
      [this](const Question& question) {
        return BytesAnswer(project_.With([&](Snapshot& now) {
          return DraftedMending(now, question.Need("pose"), question.Json());
        }));
      },
      Changes::kNothing);
}

}  // namespace keypose::studio
