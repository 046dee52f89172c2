#include "studio/routes/motion_routes.h"

#include "studio/meshes/frame_colours.h"
#include "studio/meshes/frames.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kMostTextures = 1'000'000, kWidestTexture = 100'000;

}  // namespace

void MotionRoutes::AddTo(RouteTable& table) {
  // Without a shot: the animation between the keys.
  table.Get("/api/frames", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return JsonAnswer(project_.With([&](Snapshot& now) { return FramesJson(now, shot); }));
  });
  table.Get("/api/frames/positions", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return BytesAnswer(project_.With([&](Snapshot& now) { return FramePositions(now, shot); }));
  });
  table.Get("/api/frames/first", [this](const Question& question) {
    const std::string shot = question.Get("shot");
    return BytesAnswer(project_.With([&](Snapshot& now) { return FirstFrame(now, shot); }));
  });
  // Without a frame: the scan's own texture.
  table.Get("/api/frames/texture", [this](const Question& question) {
    const std::string shot = question.Need("shot"), frame = question.Get("frame");
    const int number = frame.empty() ? 0 : WholeNumber(frame, 0, kMostTextures);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestTexture);
    const fs::path file = project_.With([&](Snapshot& now) {
      return frame.empty() ? OwnTexture(now, shot) : FrameTexture(now, shot, number);
    });
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
}

}  // namespace keypose::studio
