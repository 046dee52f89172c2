#include "studio/routes/pages.h"

#include "studio/routes/armature_routes.h"
#include "studio/routes/cameras_routes.h"
#include "studio/routes/export_routes.h"
#include "studio/routes/figure_routes.h"
#include "studio/routes/films_routes.h"
#include "studio/routes/landmarks_routes.h"
#include "studio/routes/marks_routes.h"
#include "studio/routes/masks_routes.h"
#include "studio/routes/mending_routes.h"
#include "studio/routes/motion_routes.h"
#include "studio/routes/new_project_routes.h"
#include "studio/routes/poses_routes.h"
#include "studio/routes/review_routes.h"
#include "studio/routes/run_routes.h"
#include "studio/routes/shoot_routes.h"
#include "studio/routes/shot_routes.h"
#include "studio/routes/state_routes.h"
#include "studio/routes/take_routes.h"
#include "studio/routes/timeline_routes.h"
#include "studio/routes/upkeep_routes.h"
#include "studio/routes/upload_routes.h"

namespace keypose::studio {

namespace {

template <class... Pages>
std::vector<std::unique_ptr<PageRoutes>> Make(SharedProject& project) {
  std::vector<std::unique_ptr<PageRoutes>> pages;
  (pages.push_back(std::make_unique<Pages>(project)), ...);
  return pages;
}

}  // namespace

std::vector<std::unique_ptr<PageRoutes>> AllPages(SharedProject& project) {
  return Make<ArmatureRoutes, CamerasRoutes, ExportRoutes, FigureRoutes, FilmsRoutes,
              LandmarksRoutes, MarksRoutes, MasksRoutes, MendingRoutes, MotionRoutes, NewProjectRoutes,
              PosesRoutes, ReviewRoutes, RunRoutes, ShootRoutes, ShotRoutes, StateRoutes,
              TakeRoutes, TimelineRoutes, UpkeepRoutes, UploadRoutes>(project);
}

}  // namespace keypose::studio
