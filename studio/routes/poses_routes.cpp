#include "studio/routes/poses_routes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/io/meshes/mesh_io.h"
#include "core/values/errors.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/added_photographs.h"
#include "studio/project/bin.h"
#include "studio/project/changes.h"
#include "studio/project/left_out_photographs.h"
#include "studio/project/pose_list.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostCloudPoints = 1'000'000;

/// A session would go on in a folder that is not there any more.
void RequireNoShooting(const fs::path& project) {
  const int fd = open((project / ".keypose/shoot/lock").c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return;
  const bool free = flock(fd, LOCK_EX | LOCK_NB) == 0;
  close(fd);
  if (!free) throw LockedError("a shooting session is at work; end it before poses are changed");
}

}  // namespace

void PosesRoutes::AddTo(RouteTable& table) {
  AddPhotographs(table);
  AddPhotographChanges(table);
  AddPoseChanges(table);
  AddBin(table);
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

template <class Change>
Answer PosesRoutes::Changed(const Change& change) {
  if (project_.run().running())
    throw LockedError("a run is at work; change photographs and poses when it is done");
  if (const std::string holder = project_.LockedBy(); !holder.empty())
    throw LockedError(
        fmt::format("the project is in use by {}; change photographs and poses after it", holder));
  return JsonAnswer(project_.With([&](Snapshot& now) { return change(now); }));
}

void PosesRoutes::AddPhotographChanges(RouteTable& table) {
  table.Put(
      "/api/photos",
      [this](const Question& question) {
        return Changed([&](Snapshot& now) {
          AddPhotograph(now, question.Need("pose"), question.Need("name"), question.body,
                        question.Get("replaces"));
          if (!question.Get("replaces").empty()) project_.Forget();
          return json{{"added", true}};
        });
      },
      Changes::kQuietly);
  table.Post("/api/photos/leave-out", [this](const Question& question) {
    const json body = question.Json();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      LeaveOut(now, body.at("pose"), body.at("names"), body.at("out"));
      return json{{"done", true}};
    }));
  });
  table.Post("/api/photos/delete", [this](const Question& question) {
    const json body = question.Json();
    return Changed([&](Snapshot& now) {
      return json{{"id", BinPhotographs(now, body.at("pose"), body.at("names"))}};
    });
  });
  table.Get("/api/photos/again", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return AgainJson(now, question.Need("pose")); }));
  });
}

void PosesRoutes::AddPoseChanges(RouteTable& table) {
  const auto post = [&](const char* path, auto change) {
    table.Post(path, [this, change](const Question& question) {
      const json body = question.Json();
      RequireNoShooting(project_.folder());
      return Changed([&](Snapshot& now) {
        change(now, body);
        return json{{"done", true}};
      });
    });
  };
  post("/api/poses/add",
       [](Snapshot& now, const json& body) { AddPose(now, body.at("pose"), body.at("few")); });
  post("/api/poses/rename",
       [](Snapshot& now, const json& body) { RenamePose(now, body.at("pose"), body.at("name")); });
  post("/api/poses/delete", [](Snapshot& now, const json& body) { BinPose(now, body.at("pose")); });
  post("/api/poses/order",
       [](Snapshot& now, const json& body) { OrderPoses(now, body.at("poses")); });
  post("/api/poses/template",
       [](Snapshot& now, const json& body) { ChooseTemplate(now, body.at("pose")); });
  post("/api/poses/method",
       [](Snapshot& now, const json& body) { ChooseMethod(now, body.at("pose"), body.at("few")); });
}

void PosesRoutes::AddBin(RouteTable& table) {
  table.Get("/api/bin", [this](const Question&) { return JsonAnswer(BinJson(project_.folder())); });
  table.Get("/api/bin/picture", [this](const Question& question) {
    const fs::path file = BinFile(project_.folder(), question.Need("id"), question.Need("path"));
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
  table.Post("/api/bin/take-back", [this](const Question& question) {
    const json body = question.Json();
    return Changed([&](Snapshot& now) {
      TakeBack(now, body.at("id"));
      return json{{"done", true}};
    });
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
