// Landmarks, their suggestions, and what is painted on the template.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class LandmarksRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddPicks(RouteTable& table);
  void AddFits(RouteTable& table);
  void AddPaint(RouteTable& table);
  Answer Suggest(const Question& question);
};

}  // namespace keypose::studio
