// What the server answers: the requests of docs/studio-api.md.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "studio/http/answers.h"
#include "studio/http/shared_project.h"
#include "studio/routes/page_routes.h"

namespace keypose::studio {

/// The answer that is made; what is thrown meanwhile becomes one with {"error": words}.
Answer Answered(const std::function<Answer()>& make);

class Routes {
 public:
  explicit Routes(std::filesystem::path folder);

  /// Never throws: faults are answers with {"error": words}.
  Answer Handle(const Question& question);
  EventHub& hub() { return project_.hub(); }
  bool IsRunning() { return project_.run().running(); }

 private:
  void Tell(Changes changes);

  SharedProject project_;
  std::vector<std::unique_ptr<PageRoutes>> pages_;
  RouteTable table_;
};

}  // namespace keypose::studio
