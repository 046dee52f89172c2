// The keys of the timeline.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class TimelineRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
