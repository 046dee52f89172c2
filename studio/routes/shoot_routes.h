// Shooting: a session of `keypose shoot`, its live view, and what has landed.
#pragma once

#include "studio/routes/page_routes.h"
#include "studio/runs/shoot_control.h"

namespace keypose::studio {

class ShootRoutes : public PageRoutes {
 public:
  explicit ShootRoutes(SharedProject& project);
  void AddTo(RouteTable& table) override;

 private:
  void AddSession(RouteTable& table);
  void AddPictures(RouteTable& table);

  ShootControl shoot_;
};

}  // namespace keypose::studio
