// Photographs, masks, cameras, meshes and frames.
#include <fmt/format.h>

#include "core/values/errors.h"
#include "core/io/meshes/mesh_io.h"
#include "studio/meshes/frame_colours.h"
#include "studio/meshes/frames.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/changes.h"
#include "studio/project/figure.h"
#include "studio/project/films.h"
#include "studio/project/own_masks.h"
#include "studio/project/photographs.h"
#include "studio/server/routes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostCloudPoints = 1'000'000, kMostTextures = 1'000'000, kMostFilmed = 1'000'000'000,
              kWidestTexture = 100'000;

}  // namespace

void Routes::AddPhotographs() {
  Add("GET", "/api/photos", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(With([&](Snapshot& now) {
      if (!now.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
      return PhotographsJson(now, pose);
    }));
  });
  Add("PUT", "/api/photos", [this](const Question& question) {
    if (run_->running()) throw LockedError("a run is at work; add photographs when it is done");
    With([&](Snapshot& now) {
      AddPhotograph(now, question.Need("pose"), question.Need("name"), question.body);
      return 0;
    });
    return JsonAnswer({{"added", true}});
  });
  Add("GET", "/api/photo", [this](const Question& question) {
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path source = With([&](Snapshot& now) {
      return PhotographSource(now, question.Need("pose"), question.Need("name"),
                              question.Get("stage") == "capture");
    });
    return PictureAnswer(PictureFile(PictureFolder(), source, width));
  });
  AddMasks();
}

void Routes::AddMasks() {
  Add("GET", "/api/mask", [this](const Question& question) {
    std::pair<int, int> size;
    const fs::path mask = With([&](Snapshot& now) {
      size = PhotographSize(now, question.Need("pose"), question.Need("name"));
      return MaskFile(now, question.Need("pose"), question.Need("name"),
                      question.Get("stage", "masks"));
    });
    return PictureAnswer(MaskPicture(PictureFolder(), mask, size.first, size.second));
  });
  Add("PUT", "/api/mask", [this](const Question& question) {
    const std::string pose = question.Need("pose"), name = question.Need("name");
    const std::string revision = With([&](Snapshot& now) {
      const auto tag = [&, size = PhotographSize(now, pose, name)](const fs::path& mask) {
        return TagOf(MaskPicture(PictureFolder(), mask, size.first, size.second));
      };
      if (!now.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
      const fs::path own = OwnMasks(now, pose).InForce(name);
      if (question.query.contains("revision") && !own.empty() &&
          tag(own) != question.Need("revision"))
        throw ChangedMeanwhile(fmt::format(
            "the mask of {} was changed elsewhere, and is not written over; open it again", name));
      return tag(SaveMask(now, pose, name, question.body, question.Get("photograph")));
    });
    return JsonAnswer({{"saved", true}, {"revision", revision}});
  });
  Add("POST", "/api/masks/hold", [this](const Question& question) {
    const json body = question.Json();
    With([&](Snapshot& now) {
      DecideMasks(now, body.at("pose"), body.at("names"), body.at("hold"));
      return 0;
    });
    return JsonAnswer({{"done", true}});
  });
  AddFigure();
  Add("GET", "/api/cameras", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return CamerasJson(now, question.Need("pose")); }));
  });
}

void Routes::AddFigure() {
  Add("GET", "/api/figure", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return FigureJson(now, question.Need("pose")); }));
  });
  Add("PUT", "/api/figure", [this](const Question& question) {
    return JsonAnswer(With(
        [&](Snapshot& now) { return SaveFigure(now, question.Need("pose"), question.Json()); }));
  });
}

void Routes::AddFilms() {
  Add("GET", "/api/films", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return FilmsJson(now, question.Need("shot")); }));
  });
  // Decoding takes its time: other requests need not wait for it.
  Add("GET", "/api/films/frame", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFilmed);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestTexture);
    const FrameSource film = With(
        [&](Snapshot& now) { return FilmOf(now, question.Need("shot"), question.Need("camera")); });
    return PictureAnswer(FramePicture(PictureFolder(), film, frame, width));
  });
  Add("GET", "/api/films/mask", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFilmed);
    const FrameSource masks = With([&](Snapshot& now) {
      return MasksOf(now, question.Need("shot"), question.Need("camera"));
    });
    return PictureAnswer(FrameMask(PictureFolder(), masks, frame));
  });
}

void Routes::AddMeshes() {
  const auto mesh_path = [this](const std::string& pose, MeshKind kind) {
    const auto path = With([&](Snapshot& now) { return now.MeshPath(pose, kind); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no {} yet", pose, NameOf(kind)));
    return *path;
  };
  Add("GET", "/api/mesh", [mesh_path](const Question& question) {
    const auto kind = MeshKindNamed(question.Need("what"));
    if (!kind) throw UsageError("a mesh is one of mesh, clean, refined, surface, cloud");
    const fs::path path = mesh_path(question.Need("pose"), *kind);
    if (*kind == MeshKind::kCloud)
      return BytesAnswer(CloudBytes(ReadPointCloud(path), kMostCloudPoints));
    return BytesAnswer(MeshBytes(ReadMesh(path)));
  });
  Add("GET", "/api/fit", [this, mesh_path](const Question& question) {
    const std::string pose = question.Need("pose");
    // Before the first registration there is no fit to show, which is no fault.
    // A pose from few photographs has no scan to be far from.
    if (With([&](Snapshot& now) {
          return now.IsFitted(pose) || !now.MeshPath(pose, MeshKind::kMesh);
        }))
      return BytesAnswer("");
    return BytesAnswer(FitBytes(ReadMesh(mesh_path(pose, MeshKind::kMesh)),
                                ReadMesh(mesh_path(pose, MeshKind::kClean))));
  });
}

void Routes::AddTextures() {
  Add("GET", "/api/texture", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    const auto path = With([&](Snapshot& now) { return now.TexturePath(pose); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no texture yet", pose));
    return PictureAnswer(*path);
  });
  Add("GET", "/api/confidence", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    const auto path = With([&](Snapshot& now) { return now.ConfidencePath(pose); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no confidence yet", pose));
    return PictureAnswer(*path);
  });
}

void Routes::AddFrames() {
  // Without a shot: the animation between the keys.
  Add("GET", "/api/frames", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return JsonAnswer(With([&](Snapshot& now) { return FramesJson(now, shot); }));
  });
  Add("GET", "/api/frames/positions", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return BytesAnswer(With([&](Snapshot& now) { return FramePositions(now, shot); }));
  });
  Add("GET", "/api/frames/first", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return BytesAnswer(With([&](Snapshot& now) { return FirstFrame(now, shot); }));
  });
  // Without a frame: the scan's own texture.
  Add("GET", "/api/frames/texture", [this](const Question& question) {
    const std::string shot = question.Need("shot"), frame = question.Get("frame");
    const int number = frame.empty() ? 0 : WholeNumber(frame, 0, kMostTextures);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestTexture);
    const fs::path file = With([&](Snapshot& now) {
      return frame.empty() ? OwnTexture(now, shot) : FrameTexture(now, shot, number);
    });
    return PictureAnswer(PictureFile(PictureFolder(), file, width));
  });
}

}  // namespace keypose::studio
