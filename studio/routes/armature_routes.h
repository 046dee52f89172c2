// The puppet as an input device: a session of `keypose armature live`, what its page shows, frames
// baked from what was recorded.
#pragma once

#include "studio/routes/page_routes.h"
#include "studio/runs/armature_control.h"
#include "studio/runs/calibrate_control.h"

namespace keypose::studio {

class ArmatureRoutes : public PageRoutes {
 public:
  explicit ArmatureRoutes(SharedProject& project);
  void AddTo(RouteTable& table) override;

 private:
  void AddSession(RouteTable& table);
  void AddViews(RouteTable& table);
  void AddCalibration(RouteTable& table);

  ArmatureControl armature_;
  CalibrateControl calibration_;
};

}  // namespace keypose::studio
