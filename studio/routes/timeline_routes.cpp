#include "studio/routes/timeline_routes.h"

#include "studio/project/page_timeline.h"

namespace keypose::studio {

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
}

}  // namespace keypose::studio
