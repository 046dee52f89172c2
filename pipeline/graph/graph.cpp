#include "pipeline/graph/graph.h"

#include <fmt/format.h>

#include <set>

#include "core/values/errors.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {

std::vector<int> Graph::Find(const std::string& text) const {
  const std::string selector = Composed(text);
  std::vector<int> found;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].id == selector || steps[i].rule == selector) found.push_back(static_cast<int>(i));
  }
  if (!found.empty()) return found;
  std::vector<std::string> known;
  std::set<std::string> seen;
  for (const Step& step : steps) {
    const std::string& one = selector.find('/') == std::string::npos ? step.rule : step.id;
    if (seen.insert(one).second) known.push_back(one);
  }
  throw UsageError(fmt::format("there is no step '{}' in this project{}", selector,
                               Suggestion(selector, known)));
}

}  // namespace keypose::pipeline
