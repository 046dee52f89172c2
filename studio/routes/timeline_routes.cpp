#include "studio/routes/timeline_routes.h"

#include <cmath>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "studio/project/page_sound.h"
#include "studio/project/page_timeline.h"

namespace keypose::studio {

namespace {

constexpr double kMostSoundTime_s = 3600;

}  // namespace

void TimelineRoutes::AddTo(RouteTable& table) {
  table.Get("/api/timeline", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return TimelineToPage(now); }));
  });
  table.Put("/api/timeline", [this](const Question& question) {
    return JsonAnswer(project_.With([&](Snapshot& now) {
      SaveTimeline(now, question.Json());
      // Within the same turn, so that it is not what another tab has saved meanwhile.
      return TimelineToPage(project_.ReadAgain());
    }));
  });
  AddSound(table);
}

void TimelineRoutes::AddSound(RouteTable& table) {
  const auto now_and_then = [this](const auto& change) {
    return JsonAnswer(project_.With([&](Snapshot& now) {
      change(now);
      return SoundToPage(project_.ReadAgain());
    }));
  };
  table.Get("/api/sound", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return SoundToPage(now); }));
  });
  table.Get("/api/sound/file", [this](const Question&) {
    return BytesAnswer(ReadFile(project_.With([](Snapshot& now) { return SoundFileOf(now); })));
  });
  table.Put("/api/sound", [now_and_then](const Question& question) {
    return now_and_then(
        [&](Snapshot& now) { PutSound(now, question.Need("name"), question.body); });
  });
  table.Put("/api/sound/at", [now_and_then](const Question& question) {
    const double at_s = question.Json().at("at").get<double>();
    if (!(std::abs(at_s) <= kMostSoundTime_s))
      throw UsageError("a sound begins within an hour of the timeline's begin");
    return now_and_then([&](Snapshot& now) { MoveSound(now, at_s); });
  });
  table.Put("/api/sound/remove", [now_and_then](const Question&) {
    return now_and_then([](Snapshot& now) { RemoveSound(now); });
  });
}

}  // namespace keypose::studio
