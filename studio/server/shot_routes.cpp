// The filmed shot: its film, clicks, camera and result.
#include "core/errors.h"
#include "studio/project/photographs.h"
#include "studio/project/shot.h"
#include "studio/server/routes.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kMostFrames = 1'000'000'000, kMostWidth = 100'000;

}  // namespace

void Routes::AddShot() {
  const auto whole = [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return ShotJson(now); }));
  };
  Add("GET", "/api/shot", whole);
  const auto change = [this, whole](void (*save)(Snapshot&, const nlohmann::json&)) {
    return [this, whole, save](const Question& question) {
      With([&](Snapshot& now) {
        save(now, question.Json());
        return 0;
      });
      stale_ = true;
      return whole(question);
    };
  };
  Add("PUT", "/api/shot", change(SaveShot));
  Add("PUT", "/api/shot/clicks", change(SaveClicks));
  Add("GET", "/api/shot/frame", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFrames);
    const int width = WholeNumber(question.Get("width", "0"), 0, kMostWidth);
    const fs::path file = With([&](Snapshot& now) { return FilmFrameFile(now, frame); });
    return PictureAnswer(PictureFile(PictureFolder(), file, width));
  });
  Add("GET", "/api/shot/picture", [this](const Question& question) {
    const int number = WholeNumber(question.Get("number", "0"), 0, kMostFrames);
    const int width = WholeNumber(question.Get("width", "0"), 0, kMostWidth);
    const std::string what = question.Need("what");
    const fs::path file = With([&](Snapshot& now) { return ShotPictureFile(now, what, number); });
    return PictureAnswer(PictureFile(PictureFolder(), file, width));
  });
}

}  // namespace keypose::studio
