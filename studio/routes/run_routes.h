// A run: started and stopped, why and how its steps went, and their options.
#pragma once

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class RunRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddOptions(RouteTable& table);
  void AddSteps(RouteTable& table);
  void AddRun(RouteTable& table);
  Answer Stages();

  std::mutex described_mutex_;
  std::map<std::string, nlohmann::json> described_;  ///< stages, by program and its stamp
};

}  // namespace keypose::studio
