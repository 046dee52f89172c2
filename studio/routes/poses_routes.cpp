#include "studio/routes/poses_routes.h"

#include <fmt/format.h>

#include "core/io/meshes/mesh_io.h"
#include "core/values/errors.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/changes.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostCloudPoints = 1'000'000;

}  // namespace

void PosesRoutes::AddTo(RouteTable& table) {
  AddPhotographs(table);
  AddMeshes(table);
  AddTextures(table);
}

void PosesRoutes::AddPhotographs(RouteTable& table) {
  table.Get("/api/photos", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(project_.With([&](Snapshot& now) {
      if (!now.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
      return PhotographsJson(now, pose);
    }));
  });
  table.Put(
      "/api/photos",
      [this](const Question& question) {
        if (project_.run().running())
          throw LockedError("a run is at work; add photographs when it is done");
        project_.With([&](Snapshot& now) {
          AddPhotograph(now, question.Need("pose"), question.Need("name"), question.body);
          return 0;
        });
        return JsonAnswer({{"added", true}});
      },
      Changes::kQuietly);
  table.Get("/api/photo", [this](const Question& question) {
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path source = project_.With([&](Snapshot& now) {
      return PhotographSource(now, question.Need("pose"), question.Need("name"),
                              question.Get("stage") == "capture");
    });
    return PictureAnswer(PictureFile(project_.PictureFolder(), source, width));
  });
  table.Get("/api/cameras", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return CamerasJson(now, question.Need("pose")); }));
  });
}

void PosesRoutes::AddMeshes(RouteTable& table) {
  const auto mesh_path = [this](const std::string& pose, MeshKind kind) {
    const auto path = project_.With([&](Snapshot& now) { return now.MeshPath(pose, kind); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no {} yet", pose, NameOf(kind)));
    return *path;
  };
  table.Get("/api/mesh", [mesh_path](const Question& question) {
    const auto kind = MeshKindNamed(question.Need("what"));
    if (!kind) throw UsageError("a mesh is one of mesh, clean, refined, surface, cloud");
    const fs::path path = mesh_path(question.Need("pose"), *kind);
    if (*kind == MeshKind::kCloud)
      return BytesAnswer(CloudBytes(ReadPointCloud(path), kMostCloudPoints));
    return BytesAnswer(MeshBytes(ReadMesh(path)));
  });
  table.Get("/api/fit", [this, mesh_path](const Question& question) {
    const std::string pose = question.Need("pose");
    // Before the first registration there is no fit to show, which is no fault.
    // A pose from few photographs has no scan to be far from.
    if (project_.With([&](Snapshot& now) {
          return now.IsFitted(pose) || !now.MeshPath(pose, MeshKind::kMesh);
        }))
      return BytesAnswer("");
    return BytesAnswer(FitBytes(ReadMesh(mesh_path(pose, MeshKind::kMesh)),
                                ReadMesh(mesh_path(pose, MeshKind::kClean))));
  });
}

void PosesRoutes::AddTextures(RouteTable& table) {
  table.Get("/api/texture", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    const auto path = project_.With([&](Snapshot& now) { return now.TexturePath(pose); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no texture yet", pose));
    return PictureAnswer(*path);
  });
  table.Get("/api/confidence", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    const auto path = project_.With([&](Snapshot& now) { return now.ConfidencePath(pose); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no confidence yet", pose));
    return PictureAnswer(*path);
  });
}

}  // namespace keypose::studio
