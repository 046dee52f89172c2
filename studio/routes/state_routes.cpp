#include "studio/routes/state_routes.h"

#include "core/values/errors.h"
#include "studio/project/overview.h"

namespace keypose::studio {

void StateRoutes::AddTo(RouteTable& table) {
  table.Get("/api/project", [this](const Question&) {
    if (!project_.Exists()) return JsonAnswer(EmptyProjectJson(project_.folder()));
    try {
      return JsonAnswer(project_.With([](Snapshot& now) { return ProjectJson(now); }));
    } catch (const Error& error) {
      return JsonAnswer(BrokenProjectJson(project_.folder(), error.what()));
    }
  });
  table.Get("/api/steps", [this](const Question&) {
    const bool running = project_.run().running();
    const std::string locked = project_.LockedBy();
    if (!project_.Exists()) return JsonAnswer(NoStepsJson(false, ""));
    try {
      return JsonAnswer(
          project_.With([&](Snapshot& now) { return StepsJson(now, running, locked); }));
    } catch (const Error&) {
      return JsonAnswer(NoStepsJson(running, locked));  // /api/project says what is wrong
    }
  });
}

}  // namespace keypose::studio
