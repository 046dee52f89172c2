// The cameras of a performance, calibrated by points of known place.
#pragma once

#include <atomic>

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class CamerasRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  Answer Calibrate(const Question& question);

  std::atomic<bool> calibrating_ = false;
};

}  // namespace keypose::studio
