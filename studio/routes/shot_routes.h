// The filmed shot: its film, clicks, camera and result.
#pragma once

#include <atomic>

#include "studio/routes/page_routes.h"
#include "studio/runs/warm_program.h"

namespace keypose::studio {

class ShotRoutes : public PageRoutes {
 public:
  explicit ShotRoutes(SharedProject& project);
  void AddTo(RouteTable& table) override;

 private:
  void AddParts(RouteTable& table);
  void AddPictures(RouteTable& table);
  Answer Quick(const Question& question);

  WarmProgram locate_;
  std::atomic<int> quick_number_ = 0;
};

}  // namespace keypose::studio
