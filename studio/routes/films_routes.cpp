#include "studio/routes/films_routes.h"

#include "studio/project/changes.h"
#include "studio/project/films.h"

namespace keypose::studio {

namespace {

constexpr int kMostFilmed = 1'000'000'000, kWidestFilmed = 100'000;

}  // namespace

void FilmsRoutes::AddTo(RouteTable& table) {
  table.Post("/api/films/shot", [this](const Question& question) {
    AddShot(project_.folder(), question.Json().at("shot"));
    return JsonAnswer({{"added", true}});
  });
  table.Get("/api/films", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return FilmsJson(now, question.Need("shot")); }));
  });
  // Decoding takes its time: other requests need not wait for it.
  table.Get("/api/films/frame", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFilmed);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestFilmed);
    const FrameSource film = project_.With(
        [&](Snapshot& now) { return FilmOf(now, question.Need("shot"), question.Need("camera")); });
    return PictureAnswer(FramePicture(project_.PictureFolder(), film, frame, width));
  });
  table.Get("/api/films/mask", [this](const Question& question) {
    const int frame = WholeNumber(question.Need("frame"), 0, kMostFilmed);
    const FrameSource masks = project_.With([&](Snapshot& now) {
      return MasksOf(now, question.Need("shot"), question.Need("camera"));
    });
    return PictureAnswer(FrameMask(project_.PictureFolder(), masks, frame));
  });
}

}  // namespace keypose::studio
