#include "studio/server/pages.h"

#include "studio/server/armature_routes.h"
#include "studio/server/cameras_routes.h"
#include "studio/server/export_routes.h"
#include "studio/server/figure_routes.h"
#include "studio/server/films_routes.h"
#include "studio/server/landmarks_routes.h"
#include "studio/server/masks_routes.h"
#include "studio/server/motion_routes.h"
#include "studio/server/new_project_routes.h"
#include "studio/server/poses_routes.h"
#include "studio/server/run_routes.h"
#include "studio/server/shoot_routes.h"
#include "studio/server/shot_routes.h"
#include "studio/server/state_routes.h"
#include "studio/server/take_routes.h"
#include "studio/server/timeline_routes.h"

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
              LandmarksRoutes, MasksRoutes, MotionRoutes, NewProjectRoutes, PosesRoutes, RunRoutes,
              ShootRoutes, ShotRoutes, StateRoutes, TakeRoutes, TimelineRoutes>(project);
}

}  // namespace keypose::studio
