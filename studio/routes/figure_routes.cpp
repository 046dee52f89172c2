#include "studio/routes/figure_routes.h"

#include "studio/project/figure.h"

namespace keypose::studio {

void FigureRoutes::AddTo(RouteTable& table) {
  table.Get("/api/figure", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return FigureJson(now, question.Need("pose")); }));
  });
  table.Put("/api/figure", [this](const Question& question) {
    return JsonAnswer(project_.With(
        [&](Snapshot& now) { return SaveFigure(now, question.Need("pose"), question.Json()); }));
  });
}

}  // namespace keypose::studio
