// The keys of the timeline, and its sound.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class TimelineRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddSound(RouteTable& table);
};

}  // namespace keypose::studio
